#include "app/frame_pictures.h"

#include "app/stage_store.h"

#include "scene/depth_tiff.h"
#include "scene/errors.h"
#include "scene/picture_codec.h"

namespace app {

namespace {

void write(const std::filesystem::path& path, const std::vector<std::uint8_t>& encoded) {
    if (encoded.empty()) throw scene::Failure("cannot be encoded", path, "choose a smaller --size");
    writeWhole(path, std::as_bytes(std::span(encoded)));
}

} // namespace

std::vector<std::string> writePictures(const render::EyeImage& image, const std::filesystem::path& folder,
                                       const std::string& name, bool aux) {
    std::vector<std::string> names{name + ".png"};
    write(folder / names.back(), scene::encodePng(image.colour));
    if (!aux) return names;
    names.push_back(name + "-depth.tiff");
    scene::writeNumbersTiff(image.depthMetres, folder / names.back());
    names.push_back(name + "-class.png");
    write(folder / names.back(), scene::encodePng(image.pixelClass));
    return names;
}

} // namespace app
