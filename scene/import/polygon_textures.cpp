#include "scene/import/polygon_textures.h"

#include "scene/picture_codec.h"

#include "scene/import/polygon_files.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include <assimp/scene.h>
#include <opencv2/imgproc.hpp>

namespace scene {

namespace {

constexpr int kMaxTextureSize = 16384;

/// 8 bits of blue, green, red and alpha, whatever the picture has.
cv::Mat4b toBgra(const cv::Mat& picture) {
    cv::Mat bytes = picture, bgra;
    if (picture.depth() == CV_16U) picture.convertTo(bytes, CV_8U, 1.0 / 257);
    if (bytes.depth() != CV_8U) return {};
    if (bytes.channels() == 4) return bytes;
    if (bytes.channels() == 3) cv::cvtColor(bytes, bgra, cv::COLOR_BGR2BGRA);
    if (bytes.channels() == 1) cv::cvtColor(bytes, bgra, cv::COLOR_GRAY2BGRA);
    return bgra;
}

std::string quoted(const std::string& name) {
    return "'" + name + "'";
}

} // namespace

PolygonTextures::Picture PolygonTextures::read(const std::string& named) {
    Picture picture;
    const auto missing = [&](const std::string& why) {
        scene_.remarks.push_back("texture " + quoted(named) + " " + why + "; what it is on is drawn grey");
        return Picture{};
    };
    std::vector<std::uint8_t> bytes;
    if (const aiTexture* embedded = source_.GetEmbeddedTexture(named.c_str())) {
        if (embedded->mHeight != 0) { // plain texels
            const auto width = static_cast<int>(embedded->mWidth), height = static_cast<int>(embedded->mHeight);
            if (width < 1 || height < 1 || width > kMaxTextureSize || height > kMaxTextureSize)
                return missing("has an impossible size");
            picture = {Image<Rgba8>(width, height), true};
            for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
                const aiTexel& t = embedded->pcData[i];
                picture.pixels.pixels()[i] = {t.r, t.g, t.b, t.a};
            }
            return picture;
        }
        const auto* first = reinterpret_cast<const std::uint8_t*>(embedded->pcData);
        bytes.assign(first, first + embedded->mWidth);
    } else {
        const std::filesystem::path path = findWithin(folder_, named);
        if (path.empty()) return missing("lies outside of the scene's folder");
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(path, ignored)) return missing("is not there");
        std::ifstream file(path, std::ios::binary);
        bytes.assign(std::istreambuf_iterator<char>(file), {});
        scene_.files.push_back(path);
    }
    const cv::Mat decoded = decodePicture(bytes, PictureKind::asStored);
    if (decoded.empty()) return missing("is damaged or of an unknown format");
    if (decoded.cols > kMaxTextureSize || decoded.rows > kMaxTextureSize)
        return missing("is larger than " + std::to_string(kMaxTextureSize) + " pixels");
    const cv::Mat4b bgra = toBgra(decoded);
    if (bgra.empty()) return missing("has no 8 or 16 bit colours");
    picture = {Image<Rgba8>(bgra.cols, bgra.rows), decoded.channels() == 4};
    for (int y = 0; y < bgra.rows; ++y)
        for (int x = 0; x < bgra.cols; ++x) {
            const cv::Vec4b& c = bgra(y, x);
            picture.pixels(x, y) = {c[2], c[1], c[0], c[3]};
        }
    return picture;
}

int PolygonTextures::keep(const std::string& named, Image<Rgba8> pixels) {
    if (pixels.empty()) return kNoTexture;
    scene_.textures.push_back({named, std::move(pixels)});
    return static_cast<int>(scene_.textures.size()) - 1;
}

int PolygonTextures::find(const std::string& named) {
    const auto found = colours_.find(named);
    if (found != colours_.end()) return found->second;
    Picture picture = read(named);
    alphaOf_[named] = picture.hasAlpha;
    return colours_[named] = keep(named, std::move(picture.pixels));
}

int PolygonTextures::findOpacity(const std::string& named) {
    const auto found = opacities_.find(named);
    if (found != opacities_.end()) return found->second;
    const int colour = find(named);
    if (colour == kNoTexture || alphaOf_[named]) return opacities_[named] = colour;
    Image<Rgba8> pixels = scene_.textures[static_cast<std::size_t>(colour)].pixels;
    for (Rgba8& p : pixels.pixels())
        p.a = std::max(p.r, std::max(p.g, p.b));
    return opacities_[named] = keep(named, std::move(pixels));
}

} // namespace scene
