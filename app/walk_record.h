#pragma once
// What a walk leaves behind: where the head went, pictures of what the eyes were given, figures.

#include "app/frame_report.h"
#include "app/walk_scene.h"

#include "input/path.h"
#include "scene/view.h"

namespace app {

class WalkRecord {
  public:
    /// options must outlive it.
    explicit WalkRecord(const WalkOptions& options) : options_(options) {}

    /// A time that has been rounded to before that of the last pose counts as the same: nobody reads a path that runs
    /// back.
    void addPose(double seconds, const scene::Pose& walkFromHead, const input::Rig& rig);
    bool wantsPicture(int frame) const;
    /// What the eye was given, and the camera it was given for.
    void addPicture(int frame, std::size_t eye, const scene::View& view, const render::EyeImage& image);

    /// The files that were asked for, whole. Throws scene::Failure.
    void write(const nlohmann::json& report) const;

  private:
    const WalkOptions& options_;
    input::RecordedPath path_;
    nlohmann::json cameras_ = nlohmann::json::array();
};

} // namespace app
