#pragma once
// The photographs that stand beside scans in their files: laid on their scans (N3), given their range (N4), and what
// the scans' own samples take their colours from.

#include "app/build_scene.h"
#include "app/stage_store.h"

#include "scene/depth_image.h"
#include "scene/image_store.h"
#include "scene/import/capture.h"

#include <string>
#include <vector>

#include <glm/vec4.hpp>
#include <nlohmann/json.hpp>

namespace app {

/// Of one scan.
struct ScanPhotographs {
    std::string key;                        ///< of input and options; empty: it has none
    std::vector<scene::StoredImage> images; ///< those that are used, as 3D photographs
};

struct PhotographStage {
    std::vector<ScanPhotographs> ofScan;     ///< one for each of the capture's scans
    nlohmann::json report = nullptr;         ///< what scene.json and info have; null: the capture has no photographs
    std::vector<scene::StoredImage> heldOut; ///< laid on their scans like the others, which know nothing of them
};

/// Lays every photograph on its scan. heldOut: indices of those that are kept out, ascending. What there is to say goes
/// to the capture's remarks. Throws scene::Failure.
PhotographStage layPhotographs(scene::Capture& capture, const std::vector<std::size_t>& heldOut,
                               const BuildOptions& options, StageStore& store);

/// Gives samples without colour that of the photographs which see them: the mean of all, each counting by how far
/// inside its picture the sample is seen. Photographs from beside the image's place must see the sample's surface. One
/// after another, so that only one of them need be in memory.
class SampleColours {
  public:
    /// Lends the image.
    explicit SampleColours(scene::DepthImage& image)
        : image_(image), sums_(image.camera.width, image.camera.height, glm::vec4(0)) {}

    /// Whether it can see anything that the image sees.
    bool mayTake(const scene::StoredImage& photograph) const;
    void take(const scene::DepthImage& photograph);
    void give();

  private:
    scene::DepthImage& image_;
    scene::Image<glm::vec4> sums_; ///< of colours and, last, of their weights
};

} // namespace app
