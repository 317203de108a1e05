#include "app/measure_scene.h"

#include "app/drawn_scene.h"
#include "app/frame_pictures.h"
#include "app/frame_report.h"
#include "app/governor.h"
#include "app/measure_table.h"
#include "app/output_file.h"
#include "app/progress.h"
#include "app/selection.h"
#include "app/stage_store.h"
#include "app/truth.h"
#include "app/version.h"

#include "input/path.h"
#include "render/renderer.h"
#include "scene/errors.h"
#include "scene/scene_file.h"
#include "scene/view.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

namespace app {

namespace {

using nlohmann::json;

constexpr double kFieldOfViewRadians = 1.2; ///< across, as render has it for paths
constexpr double kSamePlaceMetres = 1e-3;
/// Keys of a path from camera to camera: more would only follow the shaking of a hand.
constexpr std::size_t kMostKeys = 40;

scene::Camera eyeCamera(const MeasureOptions& o) {
    const double focal = o.width / (2 * std::tan(kFieldOfViewRadians / 2));
    return {o.width, o.height, focal, focal, o.width / 2.0, o.height / 2.0};
}

/// From each place where something was captured to the next, looking as the camera did there.
std::vector<input::PathKey> keysThroughCaptures(const scene::Scene& scene) {
    std::vector<scene::Pose> places;
    for (const scene::SceneImage& image : scene.images) {
        const scene::Pose head = image.worldFromCamera * scene::headFromCamera();
        // The faces of a cube around a scanner are one place.
        if (places.empty() || glm::distance(places.back().translation, head.translation) > kSamePlaceMetres)
            places.push_back(head);
    }
    std::vector<input::PathKey> keys;
    const std::size_t count = std::min(places.size(), kMostKeys);
    for (std::size_t i = 0; i < count; ++i)
        keys.push_back({static_cast<double>(i), places[i * places.size() / count], {}});
    return keys;
}

/// Worlds from heads that look as cameras do (z ahead), at even steps of the path's time.
std::vector<scene::Pose> headsAlong(const MeasureOptions& o, const scene::Scene& scene) {
    std::vector<input::PathKey> keys;
    if (o.path.empty()) {
        keys = keysThroughCaptures(scene);
    } else {
        input::RecordedPath recorded = input::readPath(o.path);
        const scene::Pose worldFromWalk = inverse(scene.walkFromWorld);
        for (input::PathKey& key : recorded.keys) {
            if (recorded.space == input::PathSpace::walk) key.spaceFromHead = worldFromWalk * key.spaceFromHead;
            keys.push_back(key);
        }
    }
    if (keys.empty()) throw scene::Failure("has no images to go along", o.scene, "give --path FILE");
    const input::SmoothPath path(keys);
    const double first = keys.front().seconds, length = keys.back().seconds - first;
    std::vector<scene::Pose> heads;
    for (int i = 0; i < o.frames; ++i) {
        const double seconds = o.frames > 1 ? first + length * i / (o.frames - 1) : first;
        // The last one by rounding may lie beyond the end.
        const std::optional<scene::Pose> head = path(std::min(seconds, keys.back().seconds));
        heads.push_back((head ? *head : keys.back().spaceFromHead) * scene::headFromCamera());
    }
    return heads;
}

/// What is measured, in the order of the table, and where the governor's rungs begin.
struct Plan {
    std::vector<Preset> settings;
    std::size_t ladderStart = 0;
};

Plan planOf(const MeasureOptions& o) {
    const render::Quality start = qualityOf(o.draw);
    Plan plan{o.settings.empty() ? sweepFrom(start, o.sweep) : readSettings(o.settings)};
    plan.ladderStart = plan.settings.size();
    for (const Rung& rung : ladderOf(start))
        plan.settings.push_back({rung.name, rung.quality});
    return plan;
}

std::string fileNameOf(std::string name) {
    for (char& c : name)
        if (std::string_view("/\\ =").find(c) != std::string_view::npos || static_cast<unsigned char>(c) < 32) c = '-';
    return name;
}

/// The picture of a setting that is written beside its photograph.
std::string worstOf(const std::string& setting) {
    return "worst-" + fileNameOf(setting);
}

/// The drawn picture on the left, the photograph on the right.
render::EyeImage sideBySide(const scene::Image<scene::Rgb8>& drawn, const scene::Image<scene::Rgb8>& truth) {
    render::EyeImage pair{{drawn.width() + truth.width(), drawn.height()}, {}, {}};
    for (int y = 0; y < drawn.height(); ++y) {
        std::copy(drawn.row(y).begin(), drawn.row(y).end(), pair.colour.row(y).begin());
        std::copy(truth.row(y).begin(), truth.row(y).end(), pair.colour.row(y).begin() + drawn.width());
    }
    return pair;
}

/// The scene where it is drawn.
struct Drawn {
    const render::Device& device;
    const DeviceScene& scene;
    Selection& selection;

    void prepare(std::span<const scene::View> eyes, const render::Quality& quality) const {
        scene.images->showOnly(selection.choose(eyes, quality));
        scene.images->settle(eyes, quality, scene.hidingCoverage());
    }
};

/// Every setting from every camera; returns the worst picture of each setting that is in the table, beside its
/// photograph.
std::vector<render::EyeImage> compare(const std::vector<TruthSource>& truths, const Drawn& on, const Plan& plan,
                                      std::vector<MeasuredSetting>& measured) {
    std::vector<double> worst(measured.size(), std::numeric_limits<double>::infinity());
    std::vector<render::EyeImage> worstPairs(measured.size());
    std::optional<render::Renderer> renderer;
    Progress progress("compare", truths.size());
    for (const TruthSource& source : truths) {
        const Truth truth = source.read();
        const scene::Camera& camera = source.view.camera;
        if (!renderer || renderer->width() != camera.width || renderer->height() != camera.height) {
            renderer.reset();
            renderer.emplace(on.device, *on.scene.images, camera.width, camera.height, 1, on.scene.coverage.get(),
                             on.scene.polygons.get());
        }
        const scene::View view{camera, source.view.worldFromCamera};
        for (std::size_t i = 0; i < measured.size(); ++i) {
            on.prepare({&view, 1}, plan.settings[i].quality);
            renderer->forgetWays(); // or what is hidden would hang on the photograph before
            renderer->draw({&view, 1}, plan.settings[i].quality);
            const std::vector<render::EyeImage> drawn = renderer->readBack();
            measured[i].pictures.push_back({source.view.name, errorOf(drawn[0], truth)});
            const double decibels = measured[i].pictures.back().error.psnrCovered;
            if (decibels >= worst[i]) continue;
            worst[i] = decibels;
            worstPairs[i] = sideBySide(drawn[0].colour, truth.colour);
        }
        progress.advance();
    }
    worstPairs.resize(plan.ladderStart);
    return worstPairs;
}

bool isMeasured(const json& report) {
    return report.value("revisit", json()) == "measure" && report.contains("settings") && report["settings"].is_array();
}

/// Throws scene::Failure where two settings would share a picture, or where a stranger's files would be replaced.
void checkPictures(const std::filesystem::path& folder, std::span<const Preset> settings) {
    std::vector<std::string> names{"table.md"};
    for (const Preset& setting : settings) {
        const std::string name = worstOf(setting.name) + ".png";
        if (std::ranges::find(names, name) != names.end())
            throw scene::Failure(
                "would be the picture of two settings, one of them '" + setting.name + "'", folder / name,
                "name them so that more than characters which stand in no file's name tells them apart");
        names.push_back(name);
    }
    checkReplaceableReport(folder, isMeasured);
    checkReplaceableBeside(folder, isMeasured, names);
}

/// Pictures that an earlier run wrote of settings which this one does not have. What its report does not name may be
/// anybody's.
void removeOlderPictures(const std::filesystem::path& folder, const json& report,
                         std::span<const MeasuredSetting> settings) {
    if (report.is_null()) return;
    for (const json& setting : report["settings"]) {
        if (!setting.is_object() || !setting.value("name", json()).is_string()) continue;
        const std::string picture = worstOf(setting["name"].get<std::string>());
        std::error_code ignored;
        if (std::ranges::none_of(settings, [&](const auto& other) { return worstOf(other.name) == picture; }))
            std::filesystem::remove(folder / (picture + ".png"), ignored);
    }
}

/// Every setting at every place, in turn, so that whatever else the machine does meets all of them alike.
void time(const MeasureOptions& o, const std::vector<scene::Pose>& heads, const Drawn& on, const Plan& plan,
          std::vector<MeasuredSetting>& measured) {
    render::Renderer renderer(on.device, *on.scene.images, o.width, o.height, 2, on.scene.coverage.get(),
                              on.scene.polygons.get());
    renderer.letDisplayEnlarge(true); // as in a headset
    std::vector<FrameReport> reports(measured.size());
    const scene::Camera camera = eyeCamera(o);
    const auto eyesAt = [&](const scene::Pose& head) {
        const auto [left, right] = scene::eyesOf(camera, head, o.draw.eyeDistanceMetres);
        return std::array{left, right};
    };
    // What is made when first wanted is not timed.
    for (const Preset& setting : plan.settings) {
        renderer.draw(eyesAt(heads.front()), setting.quality);
        renderer.finish();
    }
    Progress progress("time", heads.size());
    for (const scene::Pose& head : heads) {
        const std::array eyes = eyesAt(head);
        for (std::size_t i = 0; i < measured.size(); ++i) {
            on.prepare(eyes, plan.settings[i].quality);
            const auto start = std::chrono::steady_clock::now();
            renderer.draw(eyes, plan.settings[i].quality);
            const render::FrameStats stats = renderer.finish();
            const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - start;
            reports[i].add(stats, passed.count());
        }
        progress.advance();
    }
    for (std::size_t i = 0; i < measured.size(); ++i) {
        const json summary = reports[i].summarise(on.device, *on.scene.images, json::object());
        for (const char* field :
             {"frame_ms", "cpu_ms", "gpu_ms", "tiles_tested", "tiles_rejected", "tiles_drawn", "samples_drawn"})
            measured[i].times[field] = summary.at(field);
        measured[i].medianMilliseconds = summary["frame_ms"]["median"];
        measured[i].p99Milliseconds = summary["frame_ms"]["p99"];
        measured[i].processorMilliseconds = summary["cpu_ms"]["frame"]["median"];
        // A device may tell no times.
        measured[i].deviceMilliseconds = summary["gpu_ms"].contains("frame")
                                             ? summary["gpu_ms"]["frame"]["median"].get<double>()
                                             : std::numeric_limits<double>::quiet_NaN();
    }
}

} // namespace

std::vector<Preset> sweepFrom(const render::Quality& start, const std::vector<std::string>& knobNames) {
    for (const std::string& name : knobNames)
        if (std::none_of(knobs().begin(), knobs().end(), [&](const Knob& knob) { return knob.name == name; })) {
            std::string names;
            for (const Knob& knob : knobs())
                names += (names.empty() ? "" : ", ") + knob.name;
            throw scene::Failure("is no knob", "--sweep " + name, "choose from " + names);
        }
    const auto warpOf = [](const render::Quality& quality) { return toJson(quality).at("warp").get<std::string>(); };
    std::vector<Preset> settings;
    const auto add = [&](const std::string& name, const render::Quality& quality) {
        const json knobs = toJson(quality);
        for (const Preset& other : settings)
            if (toJson(other.quality) == knobs) return;
        settings.push_back({name, quality});
    };
    for (const Preset& preset : presets())
        add(preset.name, preset.quality);
    add("as asked", start);
    for (const Knob& knob : knobs()) {
        if (!knobNames.empty() && std::find(knobNames.begin(), knobNames.end(), knob.name) == knobNames.end()) continue;
        if (!knob.warp.empty() && warpOf(start) != knob.warp) continue;
        for (const json& value : knob.tried) {
            render::Quality quality = start;
            knob.set(quality, value);
            add(knob.name + "=" + (value.is_string() ? value.get<std::string>() : value.dump()), quality);
        }
    }
    return settings;
}

void measureScene(const MeasureOptions& o) {
    const Plan plan = planOf(o);
    checkPictures(o.out, std::span(plan.settings).first(plan.ladderStart));
    const scene::Scene scene = scene::openScene(o.scene);
    const std::vector<TruthSource> truths = o.cameras.empty() ? heldOutTruths(scene) : truthsBeside(o.cameras);
    const std::vector<scene::Pose> heads = headsAlong(o, scene);
    std::error_code error;
    std::filesystem::create_directories(o.out, error);
    if (error)
        throw scene::Failure("cannot be made (" + error.message() + ")", o.out, "check that the folder may be written");

    const render::Device device;
    const DeviceScene onDevice = bringTo(device, DrawnScene(scene, o.draw));
    std::vector<MeasuredSetting> measured;
    for (const Preset& setting : plan.settings)
        measured.push_back({.name = setting.name, .quality = toJson(setting.quality)});
    Selection selection(scene);
    const Drawn on{device, onDevice, selection};
    const std::vector<render::EyeImage> worst = compare(truths, on, plan, measured);
    time(o, heads, on, plan, measured);

    const std::span<const MeasuredSetting> all = measured;
    const json report{{"revisit", "measure"},
                      {"scene", o.scene.string()},
                      {"device", device.name()},
                      {"driver", device.driver()},
                      {"version", kVersion},
                      {"commit", kCommit},
                      {"width", o.width},
                      {"height", o.height},
                      {"eyes", 2},
                      {"frames", o.frames},
                      {"ipd_m", o.draw.eyeDistanceMetres},
                      {"pictures", truths.size()},
                      {"bytes_resident", onDevice.images->bytesResident()},
                      {"coverage", toJson(onDevice.coverage.get())},
                      {"settings", toJson(all.first(plan.ladderStart))},
                      {"governor_rungs", toJson(all.subspan(plan.ladderStart))}};
    const json older = reportIn(o.out, isMeasured);
    writeWhole(o.out / "report.json", report.dump(1, ' ', false, json::error_handler_t::replace) + "\n");
    const std::string table = tableOf(all, plan.ladderStart);
    writeWhole(o.out / "table.md", table);
    std::printf("%s, %dx%d, %d frames of both eyes, %zu photographs\n\n%s", device.name().c_str(), o.width, o.height,
                o.frames, truths.size(), table.c_str());
    for (std::size_t i = 0; i < worst.size(); ++i)
        writePictures(worst[i], o.out, worstOf(measured[i].name), false);
    removeOlderPictures(o.out, older, all.first(plan.ladderStart));
}

} // namespace app
