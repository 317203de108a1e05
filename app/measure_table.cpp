#include "app/measure_table.h"

#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <limits>

namespace app {

namespace {

using nlohmann::json;

struct Figure {
    const char* field; ///< in JSON
    double PictureError::*member;
};
constexpr std::array kFigures{Figure{"psnr_covered_db", &PictureError::psnrCovered},
                              Figure{"psnr_seen_db", &PictureError::psnrSeen},
                              Figure{"psnr_all_db", &PictureError::psnrAll},
                              Figure{"ssim", &PictureError::ssim},
                              Figure{"covered_share", &PictureError::coveredShare},
                              Figure{"hole_share", &PictureError::holeShare},
                              Figure{"unseen_share", &PictureError::unseenShare},
                              Figure{"wrongly_solid_share", &PictureError::wronglySolidShare}};

/// Not a number becomes null.
json toJson(const PictureError& error) {
    json object = json::object();
    for (const Figure& figure : kFigures)
        object[figure.field] = error.*figure.member;
    return object;
}

std::vector<bool> frontOf(std::span<const MeasuredSetting> settings) {
    std::vector<Trade> trades;
    for (const MeasuredSetting& setting : settings)
        trades.push_back({setting.medianMilliseconds, meanOf(setting.pictures).psnrCovered});
    return paretoFront(trades);
}

std::string number(const char* format, double value) {
    if (std::isnan(value)) return "-";
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

std::string row(std::initializer_list<std::string> cells) {
    std::string line = "|";
    for (const std::string& cell : cells) {
        line += " ";
        for (const char c : cell)
            line += c == '|' ? std::string("\\|") : std::string(1, static_cast<unsigned char>(c) < 32 ? ' ' : c);
        line += " |";
    }
    return line + "\n";
}

/// The rungs of the governor, the first of which is what was asked for.
std::string ladderTableOf(std::span<const MeasuredSetting> rungs) {
    std::string text = "\nWhat the governor gives up, rung by rung:\n\n";
    text += row({"rung", "ms", "PSNR, dB", "saves, ms", "costs, dB", "dB per ms"}) + "|---|---|---|---|---|---|\n";
    for (std::size_t i = 0; i < rungs.size(); ++i) {
        const double ms = rungs[i].medianMilliseconds, db = meanOf(rungs[i].pictures).psnrCovered;
        if (i == 0) {
            text += row({rungs[i].name, number("%.1f", ms), number("%.2f", db), "", "", ""});
            continue;
        }
        const double saves = rungs[i - 1].medianMilliseconds - ms,
                     costs = meanOf(rungs[i - 1].pictures).psnrCovered - db;
        const double each = saves > 0 ? costs / saves : std::numeric_limits<double>::quiet_NaN();
        text += row({rungs[i].name, number("%.1f", ms), number("%.2f", db), number("%.1f", saves),
                     number("%.2f", costs), number("%.2f", each)});
    }
    return text;
}

} // namespace

PictureError meanOf(std::span<const MeasuredPicture> pictures) {
    PictureError mean;
    for (const Figure& figure : kFigures) {
        double sum = 0;
        int count = 0;
        for (const MeasuredPicture& picture : pictures)
            if (const double value = picture.error.*figure.member; !std::isnan(value)) sum += value, ++count;
        mean.*figure.member = count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
    }
    return mean;
}

std::vector<bool> paretoFront(std::span<const Trade> trades) {
    std::vector<bool> isOnFront(trades.size(), true);
    for (std::size_t i = 0; i < trades.size(); ++i)
        for (const Trade& other : trades) {
            const bool isNoWorse = other.milliseconds <= trades[i].milliseconds && other.decibels >= trades[i].decibels;
            const bool isBetter = other.milliseconds < trades[i].milliseconds || other.decibels > trades[i].decibels;
            if (isNoWorse && isBetter) isOnFront[i] = false;
        }
    return isOnFront;
}

std::string tableOf(std::span<const MeasuredSetting> settings, std::size_t ladderStart) {
    const std::span<const MeasuredSetting> swept = settings.first(ladderStart);
    const std::vector<bool> isOnFront = frontOf(swept);
    std::string text = row({"setting", "ms a frame", "p99", "processor", "device", "PSNR, dB", "all pixels", "SSIM",
                            "holes, %", "wrongly solid, %", "front"}) +
                       "|---|---|---|---|---|---|---|---|---|---|---|\n";
    for (std::size_t i = 0; i < swept.size(); ++i) {
        const MeasuredSetting& s = swept[i];
        const PictureError mean = meanOf(s.pictures);
        text += row({s.name, number("%.1f", s.medianMilliseconds), number("%.1f", s.p99Milliseconds),
                     number("%.1f", s.processorMilliseconds), number("%.1f", s.deviceMilliseconds),
                     number("%.2f", mean.psnrCovered), number("%.2f", mean.psnrAll), number("%.3f", mean.ssim),
                     number("%.2f", 100 * mean.holeShare), number("%.2f", 100 * mean.wronglySolidShare),
                     isOnFront[i] ? "*" : ""});
    }
    text += "\nPSNR is over pixels that are seen or filled; holes are pixels where the photograph has range and the "
            "picture "
            "has nothing;\nwrongly solid are those that stand in front of all range within a pixel of theirs by more "
            "than " +
            number("%.0f", 100 * kSolidTolerance) + " %. front: no other setting is both faster and better.\n";
    if (ladderStart < settings.size()) text += ladderTableOf(settings.subspan(ladderStart));
    return text;
}

json toJson(std::span<const MeasuredSetting> settings) {
    const std::vector<bool> isOnFront = frontOf(settings);
    json list = json::array();
    for (std::size_t i = 0; i < settings.size(); ++i) {
        const MeasuredSetting& setting = settings[i];
        json pictures = json::array();
        for (const MeasuredPicture& picture : setting.pictures) {
            json object = toJson(picture.error);
            object["name"] = picture.name;
            pictures.push_back(std::move(object));
        }
        json object = setting.times;
        object.update(toJson(meanOf(setting.pictures)));
        object["name"] = setting.name;
        object["quality"] = setting.quality;
        object["is_on_front"] = static_cast<bool>(isOnFront[i]);
        object["pictures"] = std::move(pictures);
        list.push_back(std::move(object));
    }
    return list;
}

} // namespace app
