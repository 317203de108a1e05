#include "scene/warp_target.h"

#include "scene/footprint.h"
#include "scene/warp_points.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <memory>
#include <new>

#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>

namespace scene {

namespace {

struct Work {
    std::size_t block, tile;
};

struct Free {
    void operator()(std::uint64_t* pixels) const { std::free(pixels); }
};

/// Where one thread draws, and which rows it drew on: only those are joined.
struct Layer {
    ImageView<std::uint64_t> zBuffer;
    std::unique_ptr<std::uint64_t, Free> own;
    std::vector<std::uint8_t> isRowDrawn;
};

/// A layer of its own memory. From calloc, since large blocks of it are cleared by the system when they are first
/// touched: a thread that draws on few rows pays for few.
Layer makeLayer(int width, int height) {
    const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    Layer layer;
    layer.own.reset(static_cast<std::uint64_t*>(std::calloc(count, sizeof(std::uint64_t))));
    if (!layer.own) throw std::bad_alloc();
    layer.zBuffer = {layer.own.get(), width, height, width};
    layer.isRowDrawn.assign(static_cast<std::size_t>(height), 0);
    return layer;
}

/// A z-buffer of its own costs a thread about as much as drawing this share of its pixels' number in samples.
constexpr double kSamplesPerPixelOfLayer = 0.5;

int threadsFor(std::size_t vertices, std::size_t pixels) {
    const double repaid = static_cast<double>(vertices) / (kSamplesPerPixelOfLayer * static_cast<double>(pixels));
    return static_cast<int>(std::clamp(repaid, 1.0, static_cast<double>(tbb::this_task_arena::max_concurrency())));
}

} // namespace

void drawTiles(std::span<const TileBlock> blocks, const View& eye, const PreferenceOptions& preference,
               CountVertices vertexCount, const DrawTile& drawTile, ZBuffer& zBuffer) {
    if (zBuffer.empty()) return;
    std::vector<Work> work;
    std::vector<glm::dmat4> matrices;
    std::size_t vertices = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        matrices.push_back(eyeImageFromSourceImage(eye, blocks[b].camera, blocks[b].worldFromCamera));
        for (std::size_t t = 0; t < blocks[b].tiles.size(); ++t) {
            vertices += blocks[b].tiles[t].*vertexCount;
            work.push_back({b, t});
        }
    }
    const auto draw = [&](const Work& item, const ImageView<std::uint64_t>& into) -> RowRange {
        const TileBlock& block = blocks[item.block];
        const Tile& tile = block.tiles[item.tile];
        const auto level = orderLevelOf(tile, block.camera, block.worldFromCamera, eye, preference);
        if (!level) return {};
        const glm::dmat4& c = matrices[item.block];
        const double area = preference.areaLevels > 0 ? sampleAreaInEye(c, boxOf(tile, block.camera)) : 0;
        return drawTile(block, tile, c, tileWarpOf(tile, c, withArea(*level, area, preference)), into);
    };

    const int threads = threadsFor(vertices, zBuffer.size());
    if (threads == 1) {
        for (const Work& item : work)
            draw(item, zBuffer.view());
        return;
    }
    // Pieces of neighbouring tiles, so that a thread stays on few rows; several a thread, so that none waits for long.
    std::vector<Layer> layers(static_cast<std::size_t>(threads));
    const std::size_t pieces = std::min(work.size(), 8 * layers.size());
    std::atomic<std::size_t> nextPiece = 0;
    tbb::parallel_for(
        std::size_t{0}, layers.size(),
        [&](std::size_t i) {
            for (std::size_t piece = nextPiece++; piece < pieces; piece = nextPiece++) {
                Layer& layer = layers[i];
                if (layer.isRowDrawn.empty()) {
                    if (i > 0)
                        layer = makeLayer(zBuffer.width(), zBuffer.height());
                    else
                        layer = {zBuffer.view(), nullptr,
                                 std::vector<std::uint8_t>(static_cast<std::size_t>(zBuffer.height()))};
                }
                for (std::size_t t = piece * work.size() / pieces; t < (piece + 1) * work.size() / pieces; ++t) {
                    const RowRange rows = draw(work[t], layer.zBuffer);
                    for (int y = rows.first; y < rows.end; ++y)
                        layer.isRowDrawn[static_cast<std::size_t>(y)] = 1;
                }
            }
        },
        tbb::simple_partitioner());
    tbb::parallel_for(0, zBuffer.height(), [&](int y) {
        for (const Layer& layer : layers)
            if (layer.own && layer.isRowDrawn[static_cast<std::size_t>(y)])
                mergeKeys(layer.zBuffer.row(y), zBuffer.row(y));
    });
}

} // namespace scene
