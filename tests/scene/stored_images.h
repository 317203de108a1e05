#pragma once
// Images in files, as a build keeps them.

#include "scene/depth_tiff.h"
#include "scene/image_store.h"

#include <filesystem>
#include <vector>

namespace scene {

/// Writes each into the folder under its name, for stores that read them.
inline std::vector<StoredImage> writeImages(const std::vector<DepthImage>& images,
                                            const std::filesystem::path& folder) {
    std::vector<StoredImage> stored;
    for (const DepthImage& image : images) {
        stored.push_back({image.name, image.camera, image.worldFromCamera, folder / (image.name + ".tiff"), {}});
        writeDepthTiff(image, stored.back().file);
    }
    return stored;
}

} // namespace scene
