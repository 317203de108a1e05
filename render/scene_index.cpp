#include "render/scene_index.h"

#include "scene/footprint.h"
#include "scene/pyramid.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace render {

namespace {

constexpr std::uint32_t kTilesPerPiece = 2048; ///< some microseconds of culling: worth a task

/// In the middle by distance from the camera; infinite for the sky.
double middleReachOf(const scene::TileBlock& block) {
    std::vector<double> reaches;
    for (const scene::Tile& tile : block.tiles)
        reaches.push_back(scene::reachOf(scene::middleOf(tile, block.camera, block.worldFromCamera)));
    if (reaches.empty()) return 0;
    const auto middle = reaches.begin() + std::ssize(reaches) / 2;
    std::nth_element(reaches.begin(), middle, reaches.end());
    return *middle;
}

ResidentTile residentOf(const scene::Tile& tile, const scene::TileChunk& chunk) {
    const std::uint32_t vertices = 2 * chunk.facetCount, quads = vertices + chunk.vertexCount,
                        texels = quads + chunk.quadCount;
    ResidentTile resident;
    resident.firstVertex = vertices + tile.firstVertex - chunk.firstVertex, resident.pointCount = tile.pointCount;
    resident.firstLone = vertices + scene::firstLoneOf(tile) - chunk.firstVertex, resident.loneCount = tile.loneCount;
    resident.firstQuad = quads + tile.firstQuad - chunk.firstQuad, resident.quadCount = tile.quadCount;
    resident.facetCount = tile.facetCount;
    resident.width = tile.width, resident.height = tile.height;
    if (tile.facetCount > 0) {
        resident.firstFacet = tile.firstFacet - chunk.firstFacet;
        resident.firstTexel = texels + tile.firstTexel - chunk.firstTexel;
    }
    resident.x0 = tile.x0, resident.y0 = tile.y0;
    resident.minDisparity = tile.minDisparity, resident.maxDisparity = tile.maxDisparity;
    resident.placeBits = tile.placeBits;
    resident.steepness = tile.steepness / 255.0;
    return resident;
}

/// What tiles' heads say of where samples are is coarse, and checked: a box that goes beyond is not believed.
bool isWithin(const scene::WorldExtent& box, const ImageSphere& sphere) {
    constexpr double kSlack = 1.02; // facets
    const double radius = kSlack * sphere.radius;
    const glm::dvec3 low = sphere.centre - radius, high = sphere.centre + radius;
    return box.isFinite() && glm::min(low, box.least) == low && glm::max(high, box.most) == high;
}

} // namespace

SceneIndex::SceneIndex(std::span<const scene::TileBlock> blocks, std::size_t chunkBytes)
    : capturedImages(blocks.size()) {
    std::vector<std::uint32_t> firstChunks; // of the blocks
    for (const scene::TileBlock& block : blocks) {
        firstChunks.push_back(static_cast<std::uint32_t>(chunks.size()));
        for (const scene::TileChunk& chunk : scene::chunksOf(block, chunkBytes)) {
            IndexedChunk indexed;
            indexed.chunk = chunk;
            indexed.captured = static_cast<std::uint32_t>(firstChunks.size() - 1);
            indexed.number = static_cast<std::uint32_t>(chunks.size()) - firstChunks.back();
            measure(indexed, block);
            chunks.push_back(indexed);
        }
        surround(firstChunks.size() - 1, firstChunks.back());
        if (isWithin(block.samplesInWorld, spheres.back())) spheres.back().box = block.samplesInWorld;
    }
    for (std::size_t i = 0; i < blocks.size(); ++i)
        addImage({blocks[i].camera,
                  blocks[i].worldFromCamera,
                  {},
                  static_cast<std::uint32_t>(i),
                  0,
                  !blocks[i].coarser.empty(),
                  middleReachOf(blocks[i])},
                 blocks[i], 0, blocks[i].tiles.size(), firstChunks[i]);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        std::span<const scene::Tile> left = blocks[i].coarser;
        images[i].firstCoarser = static_cast<std::uint32_t>(images.size());
        while (!left.empty()) {
            const std::uint8_t level = left.front().level;
            std::size_t count = 0;
            while (count < left.size() && left[count].level == level)
                ++count;
            ResidentImage image = images[i];
            image.firstCoarser = image.coarserCount = 0;
            image.camera = scene::cameraAtLevel(image.camera, level);
            image.level = level;
            image.hasCoarser = count < left.size();
            const std::size_t before = blocks[i].tiles.size() + blocks[i].coarser.size() - left.size();
            addImage(image, blocks[i], static_cast<std::uint32_t>(before), count, firstChunks[i]);
            ++images[i].coarserCount;
            left = left.subspan(count);
        }
    }
}

void SceneIndex::surround(std::size_t captured, std::size_t firstChunk) {
    glm::dvec3 least(std::numeric_limits<double>::infinity()), most(-least);
    bool isBounded = true;
    for (std::size_t i = firstChunk; i < chunks.size(); ++i) {
        isBounded = isBounded && std::isfinite(chunks[i].radius);
        least = glm::min(least, chunks[i].centre - chunks[i].radius);
        most = glm::max(most, chunks[i].centre + chunks[i].radius);
    }
    spheres.resize(captured + 1);
    if (isBounded && firstChunk < chunks.size())
        spheres[captured] = {0.5 * (least + most), 0.5 * glm::length(most - least), {}};
}

void SceneIndex::addImage(const ResidentImage& image, const scene::TileBlock& block, std::uint32_t firstNumber,
                          std::size_t count, std::uint32_t firstChunk) {
    const std::size_t firstTile = tiles.size();
    std::uint32_t chunk = firstChunk;
    for (std::uint32_t number = firstNumber; number < firstNumber + count; ++number) {
        while (chunks[chunk].chunk.firstTile + chunks[chunk].chunk.tileCount <= number)
            ++chunk;
        const scene::Tile& tile = scene::tileOf(block, number);
        if (chunks[chunk].chunk.firstTile == number) chunks[chunk].firstTile = static_cast<std::uint32_t>(tiles.size());
        ResidentTile resident = residentOf(tile, chunks[chunk].chunk);
        resident.image = static_cast<std::uint32_t>(images.size()), resident.chunk = chunk;
        resident.middle = scene::middleOf(tile, image.camera, image.worldFromCamera);
        tiles.push_back(resident);
        bounds.append(tile, image.camera);
    }
    images.push_back(image);
    images.back().extent = bounds.extentOf(firstTile, count);
    images.back().firstPiece = static_cast<std::uint32_t>(pieces.size());
    for (std::size_t first = firstTile; first < tiles.size(); first += pieces.back().count)
        pieces.push_back(pieceFrom(first));
    images.back().pieceCount = static_cast<std::uint32_t>(pieces.size()) - images.back().firstPiece;
}

void SceneIndex::findPiecesOf(std::span<const std::uint32_t> ofImages, std::vector<std::uint32_t>& numbers) const {
    numbers.clear();
    for (const std::uint32_t i : ofImages)
        for (std::uint32_t k = 0; k < images[i].pieceCount; ++k)
            numbers.push_back(images[i].firstPiece + k);
}

TilePiece SceneIndex::pieceFrom(std::size_t first) const {
    const auto isBase = [](const ResidentTile& tile) { return scene::isForAllEyes(tile.middle.tier); };
    TilePiece piece{tiles[first].image, static_cast<std::uint32_t>(first), 0};
    piece.isBase = isBase(tiles[first]);
    piece.reachMetres = 0;
    for (std::size_t i = first; i < tiles.size() && piece.count < kTilesPerPiece; ++i, ++piece.count) {
        if (isBase(tiles[i]) != piece.isBase) break;
        piece.reachMetres = std::max(piece.reachMetres, scene::reachOf(tiles[i].middle));
    }
    piece.box = bounds.boxAround(first, piece.count);
    return piece;
}

void SceneIndex::measure(IndexedChunk& indexed, const scene::TileBlock& block) {
    const scene::Camera camera = scene::cameraAtLevel(block.camera, indexed.chunk.level);
    float nearest = 0, farthest = std::numeric_limits<float>::infinity();
    glm::dvec3 least(std::numeric_limits<double>::infinity()), most(-least);
    for (std::uint32_t i = indexed.chunk.firstTile; i < indexed.chunk.firstTile + indexed.chunk.tileCount; ++i) {
        const scene::Tile& tile = scene::tileOf(block, i);
        const scene::SampleBox box = scene::boxOf(tile, camera);
        nearest = std::max(nearest, tile.maxDisparity), farthest = std::min(farthest, tile.minDisparity);
        indexed.reach = std::max(indexed.reach, scene::reachOf(scene::middleOf(tile, camera, block.worldFromCamera)));
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 s((corner & 1) != 0 ? box.most.x : box.least.x,
                               (corner & 2) != 0 ? box.most.y : box.least.y,
                               (corner & 4) != 0 ? box.most.z : box.least.z);
            const glm::dvec3 p = block.worldFromCamera * (scene::rayThrough(camera, s.x, s.y) / s.z);
            least = glm::min(least, p), most = glm::max(most, p);
        }
    }
    const double focal = std::sqrt(camera.fx * camera.fy);
    if (farthest > 0) { // no sky
        indexed.least = least, indexed.most = most;
        indexed.centre = 0.5 * (least + most);
        indexed.radius = 0.5 * glm::length(most - least);
    }
    indexed.spacing = nearest > 0 ? 1 / (focal * static_cast<double>(nearest)) : 1 / focal;
    if (farthest > 0) indexed.widestSpacing = 1 / (focal * static_cast<double>(farthest));
}

void SceneIndex::findFiner() {
    // A coarse sample is of the first tier that one below it is of: others of that tier may be missing, no more; but
    // base ones stand for closed ones, too, and without those there would be holes. Chunks of a level and tier by the
    // places of their tiles, counted in tiles of the largest size.
    constexpr int kCell = scene::kMaxTileSize + 1;
    std::map<std::tuple<std::uint32_t, std::uint32_t, scene::Tier, int, int>, std::vector<std::uint32_t>> at;
    const auto forCells = [](const TileBounds& boxes, std::uint32_t i, int scale, auto&& visit) {
        const auto cell = [&](float v) { return static_cast<int>(v) * scale / kCell; };
        // A vertex may stand one sample outside of its tile: to the right and below.
        for (int y = cell(boxes.yMin[i]); y <= (static_cast<int>(boxes.yMax[i]) * scale + scale - 1) / kCell; ++y)
            for (int x = cell(boxes.xMin[i]); x <= (static_cast<int>(boxes.xMax[i]) * scale + scale - 1) / kCell; ++x)
                visit(x, y);
    };
    for (std::uint32_t i = 0; i < tiles.size(); ++i) {
        const ResidentImage& image = images[tiles[i].image];
        if (!image.hasCoarser) continue;
        forCells(bounds, i, 1, [&](int x, int y) {
            std::vector<std::uint32_t>& list = at[{image.captured, image.level, tiles[i].middle.tier, x, y}];
            if (list.empty() || list.back() != tiles[i].chunk) list.push_back(tiles[i].chunk);
        });
    }
    firstFiner_.assign(1, 0);
    for (std::uint32_t i = 0; i < tiles.size(); ++i) {
        const ResidentImage& image = images[tiles[i].image];
        const std::size_t before = finer_.size();
        if (image.level > 0)
            forCells(bounds, i, 2, [&](int x, int y) {
                const auto addOf = [&](scene::Tier tier) {
                    const auto list = at.find({image.captured, image.level - 1, tier, x, y});
                    if (list != at.end()) finer_.insert(finer_.end(), list->second.begin(), list->second.end());
                };
                addOf(tiles[i].middle.tier);
                if (tiles[i].middle.tier == scene::Tier::base) addOf(scene::Tier::closed);
            });
        const auto first = finer_.begin() + static_cast<std::ptrdiff_t>(before);
        std::sort(first, finer_.end());
        finer_.erase(std::unique(first, finer_.end()), finer_.end());
        firstFiner_.push_back(static_cast<std::uint32_t>(finer_.size()));
    }
}

} // namespace render
