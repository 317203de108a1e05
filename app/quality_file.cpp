#include "app/quality_file.h"

#include "scene/errors.h"
#include "scene/json_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <type_traits>

namespace app {

namespace {

using nlohmann::json;
using render::Quality;

struct WarpName {
    const char* name;
    render::Warp warp;
    bool isBlended = false;
    bool isByConfidence = false;
};
constexpr std::array kWarpNames{WarpName{"points", render::Warp::points},
                                WarpName{"mesh", render::Warp::mesh},
                                WarpName{"adaptive", render::Warp::adaptive},
                                WarpName{"splats", render::Warp::splats},
                                WarpName{"confidence", render::Warp::mesh, false, true},
                                WarpName{"blended", render::Warp::mesh, true}};

/// Order levels for each square pixel of a sample's projected area, where warps are told apart by name.
constexpr float kConfidenceLevels = 2;

/// As few digits as tell the number apart from its neighbours: 0.07 and not 0.0700000003.
template <class T>
double shortest(T value) {
    std::array<char, 64> text{};
    const char* const end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
    double shortened = 0;
    std::from_chars(text.data(), end, shortened);
    return shortened;
}

/// Units follow their numbers; names are joined by commas.
std::string inWords(double number) {
    std::array<char, 64> text{};
    return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr};
}
std::string listed(const std::vector<std::string>& names) {
    std::string list;
    for (const std::string& name : names)
        list += (list.empty() ? "" : ", ") + name;
    return list;
}

struct Range {
    double least, most;
};

/// A knob that is a number. member: the Quality, const or not, to its number.
template <class Member>
Knob number(const char* name, const char* unit, const char* does, Range range, std::vector<json> tried, Member member,
            const char* warp = "") {
    using T = std::remove_cvref_t<decltype(member(std::declval<Quality&>()))>;
    constexpr bool isWhole = std::is_integral_v<T>;
    Knob knob;
    knob.name = name, knob.unit = unit, knob.does = does, knob.tried = std::move(tried), knob.warp = warp;
    if (!knob.warp.empty()) knob.does = knob.warp + ": " + knob.does;
    knob.values = std::string(isWhole ? "a whole number" : "a number") + " of " + inWords(range.least) + " to " +
                  inWords(range.most) + (knob.unit.empty() ? "" : " " + knob.unit);
    knob.get = [member](const Quality& q) -> json {
        if constexpr (isWhole)
            return member(q);
        else
            return shortest(member(q));
    };
    knob.set = [member, range](Quality& q, const json& value) {
        if (!value.is_number()) return false;
        const double given = value.get<double>();
        if (!(given >= range.least && given <= range.most) || (isWhole && given != std::floor(given))) return false;
        member(q) = static_cast<T>(given);
        return true;
    };
    return knob;
}

/// A knob that is on or off.
template <class Member>
Knob yesOrNo(const char* name, const char* does, std::vector<json> tried, Member member) {
    Knob knob;
    knob.name = name, knob.does = does, knob.values = "true or false", knob.tried = std::move(tried);
    knob.get = [member](const Quality& q) -> json { return member(q); };
    knob.set = [member](Quality& q, const json& value) {
        if (!value.is_boolean()) return false;
        member(q) = value.get<bool>();
        return true;
    };
    return knob;
}

Knob warpKnob() {
    Knob knob;
    knob.name = "warp", knob.does = "how samples become pixels";
    for (const WarpName& row : kWarpNames)
        knob.names.emplace_back(row.name), knob.tried.emplace_back(row.name);
    knob.values = "one of " + listed(knob.names);
    knob.get = [](const Quality& q) -> json {
        const bool isByConfidence = q.preference.areaLevels > 0;
        const auto isIt = [&](const WarpName& row) {
            return row.isBlended == q.isBlended && row.isByConfidence == isByConfidence && row.warp == q.warp;
        };
        const auto row = std::find_if(kWarpNames.begin(), kWarpNames.end(), isIt);
        if (row != kWarpNames.end()) return row->name;
        return q.isBlended ? "blended" : "confidence"; // of other warps than the mesh: there is no name
    };
    knob.set = [](Quality& q, const json& value) {
        for (const WarpName& row : kWarpNames)
            if (value == row.name) {
                q.warp = row.warp, q.isBlended = row.isBlended;
                q.preference.areaLevels = row.isByConfidence ? kConfidenceLevels : 0;
                return true;
            }
        return false;
    };
    return knob;
}

std::vector<Knob> makeKnobs() {
    return {
        warpKnob(),
        number(
            "resolution_scale", "",
            "pixels along a side of what is warped, over those of the picture; above 1 smooths edges",
            {render::kMinResolutionScale, render::kMaxResolutionScale}, {0.5, 0.7, 0.85, 1.5, 2.0},
            [](auto& q) -> auto& { return q.resolutionScale; }),
        number(
            "sample_pixels", "pixels",
            "all but the mesh: coarser samples stand for finer ones where they are no wider; 0: never",
            {0, kMostSamplePixels}, {0, 1, 1.5}, [](auto& q) -> auto& { return q.samplePixels; }),
        number(
            "far_sample_pixels", "pixels",
            "the same for what was taken from far away and is seen only where nothing nearer was",
            {0, kMostSamplePixels}, {0, 1, 2, 3}, [](auto& q) -> auto& { return q.farSamplePixels; }),
        yesOrNo(
            "leave_out_hidden",
            "images that unseen space hides, where that is shown, and without a graphics card tiles behind what is "
            "drawn already are left out; pictures are the same but for gaps that are filled anyway, and colours that "
            "are blended or interpolated with what stands right behind",
            {false}, [](auto& q) -> auto& { return q.leavesOutHidden; }),
        yesOrNo(
            "one_pass",
            "points and splats: both eyes are warped in one pass that reads each sample once, where no squares_near "
            "are "
            "drawn; pictures are the same",
            {true}, [](auto& q) -> auto& { return q.isOnePass; }),
        number(
            "near_baseline", "",
            "images taken from within this share of a surface's distance are preferred there; 0: the nearest sample "
            "wins",
            {0, 10}, {0, 0.04, 0.15}, [](auto& q) -> auto& { return q.preference.nearBaseline; }),
        number(
            "max_footprint", "pixels", "widest square of pixels for a sample; 1: one pixel each", {1, 64}, {1, 2, 8},
            [](auto& q) -> auto& { return q.maxFootprint; }, "points"),
        number(
            "footprint_scale", "", "width of the square over what closes the holes within one surface", {0.1, 10},
            {0.65, 1.0, 1.25}, [](auto& q) -> auto& { return q.footprintScale; }, "points"),
        yesOrNo(
            "interpolate_samples",
            "points and splats: a pixel is made of the four samples that it lies between, by where they stand; "
            "smoother and truer than its own alone",
            {false}, [](auto& q) -> auto& { return q.interpolatesSamples; }),
        yesOrNo(
            "squares_near",
            "points and splats: where samples are seen farther apart than max_footprint, or 3 pixels since their "
            "surface slopes, squares between them are drawn instead; points on lesser slopes are two pixels wide at "
            "least",
            {false}, [](auto& q) -> auto& { return q.drawsSquaresNear; }),
        yesOrNo(
            "lone_samples", "the mesh, adaptive or not: samples that are in none of its squares are drawn as points",
            {false}, [](auto& q) -> auto& { return q.drawsLone; }),
        number(
            "hole_radius", "pixels", "pixels that no sample reached are filled from surfaces this far about; 0: never",
            {0, render::kMostHoleRadius}, {0, 1, 8}, [](auto& q) -> auto& { return q.holes.radius; }),
        number(
            "hole_same_surface", "", "relative difference in depth up to which a hole's two ends are of one surface",
            {0, 1}, {0.01, 0.1}, [](auto& q) -> auto& { return q.holes.sameSurface; }),
        yesOrNo(
            "walk_cells",
            "where whole images were taken all round from several positions, only those of the positions about the "
            "walker are drawn",
            {false}, [](auto& q) -> auto& { return q.walksByCells; }),
        number(
            "edge_samples", "samples",
            "polygons: so many of each pixel (1, 2, 4 or 8, as the device has them) smooth their edges", {1, 8}, {4},
            [](auto& q) -> auto& { return q.edgeSamples; }),
        yesOrNo(
            "show_unseen", "where no image ever looked is shown as unseen, else as emptiness", {false},
            [](auto& q) -> auto& { return q.showUnseen; }),
        yesOrNo(
            "mark_unmeasured",
            "what was not measured is tinted: what was filled or guessed orange, where nothing was seen violet", {},
            [](auto& q) -> auto& { return q.marksUnmeasured; }),
        number(
            "unseen_pocket", "m", "an eye in unseen space looks through so much of it", {0, 1000}, {0},
            [](auto& q) -> auto& { return q.unseenPocketMetres; }),
        number(
            "blend_baseline", "", "images from farther off than this share of the distance are left out", {0, 100},
            {1.5}, [](auto& q) -> auto& { return q.blend.baseline; }, "blended"),
        number(
            "blend_quarter_baseline", "", "at this share of the distance an image counts a quarter", {1e-4, 10},
            {0.015, 0.1}, [](auto& q) -> auto& { return q.blend.quarterBaseline; }, "blended"),
        number(
            "blend_depth_tolerance", "", "relative difference in depth up to which samples are of one surface", {0, 1},
            {0.03}, [](auto& q) -> auto& { return q.blend.depthTolerance; }, "blended"),
        number(
            "blend_samples_radius", "samples", "radius of a sample's spot", {0.1, 10}, {1.0},
            [](auto& q) -> auto& { return q.blend.samplesRadius; }, "blended"),
        number(
            "blend_pixels_radius", "pixels", "what a spot is widened by", {0.1, 10}, {0.5},
            [](auto& q) -> auto& { return q.blend.pixelsRadius; }, "blended"),
    };
}

Quality drawn(const char* warp, double resolutionScale) {
    Quality quality;
    warpKnob().set(quality, warp);
    // Gaps of a pixel are better filled than covered by wider squares: + 1.3 dB (docs/performance.md).
    quality.footprintScale = 0.8;
    // What is sampled finer than the eye's pixels looks the same and costs a fifth more where scans are dense (there,
    // too).
    quality.samplePixels = 1;
    quality.resolutionScale = resolutionScale;
    quality.preference = {};
    quality.holes.radius = 4;
    quality.drawsSquaresNear = true;
    quality.drawsLone = true;
    quality.interpolatesSamples = true;
    return quality;
}

std::vector<Preset> makePresets() {
    return {{"fast", drawn("points", 0.7)}, {"balanced", drawn("points", 1)}, {"best", drawn("blended", 1)}};
}

void requireObject(const json& object, const std::string& where) {
    if (!object.is_object())
        throw scene::Failure("is not an object of knobs", where, "write {\"warp\": \"mesh\", \"max_footprint\": 4}");
}

template <class Named>
std::string namesOf(std::span<const Named> list) {
    std::vector<std::string> names;
    for (const Named& item : list)
        names.push_back(item.name);
    return listed(names);
}

const Preset* findPreset(const std::string& name) {
    for (const Preset& preset : presets())
        if (preset.name == name) return &preset;
    return nullptr;
}

} // namespace

std::span<const Knob> knobs() {
    static const std::vector<Knob> all = makeKnobs();
    return all;
}

std::span<const Preset> presets() {
    static const std::vector<Preset> all = makePresets();
    return all;
}

void turnKnob(Quality& quality, const std::string& name, const json& value, const std::string& where) {
    for (const Knob& knob : knobs()) {
        if (knob.name != name) continue;
        if (knob.set(quality, value)) return;
        throw scene::Failure("has " + name + " = " + value.dump(-1, ' ', false, json::error_handler_t::replace), where,
                             "give " + knob.values);
    }
    throw scene::Failure("names a knob that there is not (" + name + ")", where, "choose from " + namesOf(knobs()));
}

json toJson(const Quality& quality) {
    json object = json::object();
    for (const Knob& knob : knobs())
        object[knob.name] = knob.get(quality);
    return object;
}

Quality qualityOf(const json& object, const std::string& where) {
    requireObject(object, where);
    const json base = object.value("preset", json(kDefaultPreset));
    const Preset* const preset = base.is_string() ? findPreset(base.get<std::string>()) : nullptr;
    if (preset == nullptr)
        throw scene::Failure("starts from a preset that there is not", where, "choose from " + namesOf(presets()));
    Quality quality = preset->quality;
    for (const auto& [name, value] : object.items())
        if (name != "preset") turnKnob(quality, name, value, where);
    return quality;
}

Quality readQuality(const std::string& presetOrFile) {
    if (const Preset* const preset = findPreset(presetOrFile)) return preset->quality;
    if (!std::filesystem::exists(presetOrFile))
        throw scene::Failure("is neither a preset nor a file", "--quality " + presetOrFile,
                             "give " + namesOf(presets()) + ", or a JSON file of knobs");
    return qualityOf(scene::readJsonFile(presetOrFile), presetOrFile);
}

std::vector<Preset> readSettings(const std::filesystem::path& file) {
    const json root = scene::readJsonFile(file);
    if (!root.is_object() || !root.contains("settings") || !root["settings"].is_array() || root["settings"].empty())
        throw scene::Failure("lists no settings", file, R"(write {"settings": [{"name": "a", "warp": "mesh"}]})");
    std::vector<Preset> settings;
    for (std::size_t i = 0; i < root["settings"].size(); ++i) {
        const std::string where = file.string() + ", setting " + std::to_string(i);
        json object = root["settings"][i];
        requireObject(object, where);
        if (!object.contains("name") || !object["name"].is_string() || object["name"].get<std::string>().empty())
            throw scene::Failure("has no name", where, "give each its \"name\"");
        const std::string name = object["name"];
        for (const Preset& other : settings)
            if (other.name == name)
                throw scene::Failure("has the name of another (" + name + ")", where, "name each differently");
        object.erase("name");
        settings.push_back({name, qualityOf(object, where)});
    }
    return settings;
}

} // namespace app
