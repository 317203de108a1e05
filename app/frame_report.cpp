#include "app/frame_report.h"

#include "app/version.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace app {

namespace {

using nlohmann::json;

std::string stepName(const char* unit, const render::StepTime& time) {
    const char* eye = time.eye == render::kWholeFrame ? "" : time.eye == 0 ? ".left" : ".right";
    return std::string(unit) + "." + time.step + eye;
}

/// When each step began and ended, from the first one on: which ran at the same time.
json traceOf(const std::vector<render::StepTime>& times) {
    json trace = json::array();
    double first = std::numeric_limits<double>::infinity();
    for (const render::StepTime& time : times)
        first = std::min(first, time.startMilliseconds);
    for (const render::StepTime& time : times) {
        const double start = time.startMilliseconds - first;
        const char* const eye = time.eye == render::kWholeFrame ? "both" : time.eye == 0 ? "left" : "right";
        trace.push_back(
            {{"step", time.step}, {"eye", eye}, {"start_ms", start}, {"end_ms", start + time.milliseconds}});
    }
    return trace;
}

double spanOf(const std::vector<render::StepTime>& times) {
    double start = std::numeric_limits<double>::infinity(), end = 0;
    for (const render::StepTime& time : times) {
        if (std::strcmp(time.step, "wait") == 0) continue;
        start = std::min(start, time.startMilliseconds);
        end = std::max(end, time.startMilliseconds + time.milliseconds);
    }
    return std::max(end - start, 0.0);
}

} // namespace

double processorMilliseconds(const render::FrameStats& stats) {
    return spanOf(stats.cpu);
}

double deviceMilliseconds(const render::FrameStats& stats) {
    return spanOf(stats.gpu);
}

void FrameReport::add(const render::FrameStats& stats, double wallMilliseconds) {
    ++frames_;
    framesInOnePass_ += stats.isOnePass ? 1 : 0;
    framesStanding_ += stats.isStanding ? 1 : 0;
    last_ = stats;
    milliseconds_["wall.frame"].add(wallMilliseconds);
    milliseconds_["cpu.frame"].add(processorMilliseconds(stats));
    if (!stats.gpu.empty()) milliseconds_["gpu.frame"].add(deviceMilliseconds(stats));
    for (const render::StepTime& time : stats.cpu)
        milliseconds_[stepName("cpu", time)].add(time.milliseconds);
    for (const render::StepTime& time : stats.gpu)
        milliseconds_[stepName("gpu", time)].add(time.milliseconds);
    double tested = 0, rejected = 0, drawn = 0, samples = 0, triangles = 0;
    for (const render::EyeCounts& eye : stats.eyes) {
        tested += eye.tilesTested, rejected += eye.tilesRejected, drawn += eye.tilesDrawn;
        samples += static_cast<double>(eye.samplesDrawn);
        triangles += static_cast<double>(eye.trianglesDrawn);
    }
    hasDrawn_ = hasDrawn_ || samples > 0 || triangles > 0;
    tested_.add(tested), rejected_.add(rejected), drawn_.add(drawn), samples_.add(samples), triangles_.add(triangles);
}

json toJson(const render::GpuCoverage* coverage) {
    if (coverage == nullptr) return nullptr;
    return {{"bytes", coverage->bytes()}, {"finest_m", coverage->finestCellMetres()}, {"levels", coverage->levels()}};
}

std::optional<std::string> FrameReport::remark() const {
    if (frames_ == 0 || hasDrawn_) return std::nullopt;
    return "nothing of the scene is in view in any frame: if that is not what was meant, look at the path or the "
           "cameras; positions are in metres, in space \"walk\" from where the scene's walk starts, with +Y up";
}

json FrameReport::summarise(const render::Device& device, const render::GpuScene& scene, json settings) const {
    json cpu = json::object(), gpu = json::object();
    json frame;
    for (const auto& [name, values] : milliseconds_) {
        if (name.starts_with("cpu.")) cpu[name.substr(4)] = values.toJson();
        if (name.starts_with("gpu.")) gpu[name.substr(4)] = values.toJson();
        if (name == "wall.frame") frame = values.toJson();
    }
    json report = std::move(settings);
    report["device"] = device.name();
    report["driver"] = device.driver();
    report["version"] = kVersion;
    report["commit"] = kCommit;
    report["frames"] = frames_;
    report["frames_in_one_pass"] = framesInOnePass_;
    report["frames_standing"] = framesStanding_;
    report["frame_ms"] = frame;
    if (!frame.is_null()) report["frames_per_second_median"] = 1000.0 / std::max(frame["median"].get<double>(), 1e-6);
    report["cpu_ms"] = cpu;
    report["gpu_ms"] = gpu;
    report["last_frame"] = {{"cpu", traceOf(last_.cpu)}, {"gpu", traceOf(last_.gpu)}};
    report["tiles_tested"] = tested_.toJson();
    report["tiles_rejected"] = rejected_.toJson();
    report["tiles_drawn"] = drawn_.toJson();
    report["samples_drawn"] = samples_.toJson();
    report["triangles_drawn"] = triangles_.toJson();
    report["bytes_resident"] = scene.bytesResident();
    if (scene.isStreamed()) {
        const render::StreamCounts counts = scene.streamCounts();
        report["stream"] = {{"bytes_kept", scene.bytesKept()},
                            {"bytes_there", counts.bytesThere},
                            {"chunks", scene.index().chunks.size()},
                            {"chunks_loaded", counts.loaded},
                            {"chunks_left", counts.left},
                            {"bytes_loaded", counts.bytesLoaded}};
    }
    return report;
}

} // namespace app
