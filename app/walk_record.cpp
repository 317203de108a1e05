#include "app/walk_record.h"

#include "app/frame_pictures.h"
#include "app/stage_store.h"

#include "scene/camera_json.h"

#include <algorithm>
#include <cstdio>

namespace app {

using nlohmann::json;

void WalkRecord::addPose(double seconds, const scene::Pose& walkFromHead, const input::Rig& rig) {
    if (options_.record.empty()) return;
    const double last = path_.keys.empty() ? seconds : path_.keys.back().seconds;
    path_.keys.push_back({std::max(seconds, last), walkFromHead, rig});
}

bool WalkRecord::wantsPicture(int frame) const {
    return options_.pictureEvery > 0 && !options_.out.empty() && frame % options_.pictureEvery == 0;
}

void WalkRecord::addPicture(int frame, std::size_t eye, const scene::View& view, const render::EyeImage& image) {
    char name[64];
    std::snprintf(name, sizeof name, "frame-%06d-%s", frame, eye == 0 ? "left" : "right");
    writePictures(image, options_.out, name, false);
    cameras_.push_back(scene::describeCamera(name, view.camera, view.worldFromEye));
}

void WalkRecord::write(const json& report) const {
    if (!options_.record.empty() && !path_.keys.empty()) writeWhole(options_.record, input::textOf(path_));
    if (!cameras_.empty()) writeWhole(options_.out / "cameras.json", json{{"cameras", cameras_}}.dump(1) + "\n");
    if (!options_.out.empty())
        writeWhole(options_.out / "report.json", report.dump(1, ' ', false, json::error_handler_t::replace) + "\n");
}

} // namespace app
