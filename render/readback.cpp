#include "render/readback.h"

#include "render/device.h"

#include <algorithm>

namespace render {

namespace {

/// The first values of a buffer: in it, or in a copy, since the processor may see a card's memory, but slowly.
template <class T>
std::span<const T> read(const Device& device, const Buffer& buffer, std::size_t count, Buffer& copy) {
    if (device.isProcessor() && buffer.mapped() != nullptr) return buffer.as<const T>().first(count);
    copy = download(device, buffer, count * sizeof(T));
    return copy.as<const T>();
}

} // namespace

EyeImage readBack(const Device& device, const EyeTarget& target, int width, int height) {
    EyeImage image{{width, height}, {width, height}, {width, height}};
    Buffer coloursCopy, depthsCopy;
    const auto colours = read<std::uint32_t>(device, target.colours, image.colour.size(), coloursCopy);
    const auto depths = read<float>(device, target.depths, image.colour.size(), depthsCopy);
    for (std::size_t i = 0; i < image.colour.size(); ++i) {
        const std::uint32_t c = colours[i];
        image.colour.pixels()[i] = {static_cast<std::uint8_t>(c), static_cast<std::uint8_t>(c >> 8),
                                    static_cast<std::uint8_t>(c >> 16)};
        image.pixelClass.pixels()[i] = static_cast<std::uint8_t>(c >> 24);
    }
    std::copy(depths.begin(), depths.end(), image.depthMetres.pixels().begin());
    return image;
}

} // namespace render
