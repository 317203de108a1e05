#pragma once
// Depth images on disk: a TIFF of three pages that ordinary tools open.
//
//   page 1  colour, 8 bit RGB         page 2  disparity, 32 bit float, 1/m       page 3  flags, 8 bit
//
// Each page is deflated in strips. The first page's ImageDescription is JSON: {"revisit": "depth image", "version": 1,
// "name", "width", "height", "fx", "fy", "cx", "cy", "world_from_camera": [16, row-major], "checksum": "xxh3-64 of the
// three pages", "description_checksum": "xxh3-64 of all this without itself, dumped with sorted keys and no spaces"}.

#include "scene/depth_image.h"

#include <filesystem>

namespace scene {

/// Writes under a temporary name beside path and renames: the file is whole or not there. Throws Failure (disk full,
/// ...).
void writeDepthTiff(const DepthImage& image, const std::filesystem::path& path);

/// Reads what writeDepthTiff wrote; everything is checked before it is used. Throws Failure with path and cause.
/// spare: an image that nobody needs any more; where it is of the same size its memory is written anew, which
/// spares the system to find and to clear other.
DepthImage readDepthTiff(const std::filesystem::path& path, DepthImage spare = {});

/// Name, camera and pose alone; the pictures are empty.
DepthImage readDepthTiffHeader(const std::filesystem::path& path);

/// The flags alone: one page, same rules.
void writeFlagsTiff(const Image<std::uint8_t>& flags, const std::filesystem::path& path);
Image<std::uint8_t> readFlagsTiff(const std::filesystem::path& path, const Camera& camera);

/// One page of a number each pixel, under its name once it is whole. Throws Failure.
void writeNumbersTiff(const Image<float>& numbers, const std::filesystem::path& path);

} // namespace scene
