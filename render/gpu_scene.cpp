#include "render/gpu_scene.h"

#include "render/check.h"
#include "render/chunk_bytes.h"
#include "render/device.h"
#include "scene/errors.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>
#include <utility>

namespace render {

namespace {

std::size_t bytesOf(const SceneIndex& index) {
    std::size_t bytes = 0;
    for (const IndexedChunk& chunk : index.chunks)
        bytes += chunk.chunk.bytes();
    return bytes;
}

/// Of what is needed no less is told, of what there is no more.
std::string mebibytes(std::size_t bytes, bool isNeeded) {
    const double tenths = static_cast<double>(bytes) * 10 / (1 << 20);
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.1f MiB", (isNeeded ? std::ceil(tenths) : std::floor(tenths)) / 10);
    return text.data();
}

} // namespace

GpuScene::GpuScene(const Device& device, std::span<const scene::TileBlock> blocks, const SceneMemory& memory) {
    SceneMemory possible = memory;
    possible.pageBytes = std::min(memory.pageBytes, device.limits().maxTexelBufferElements * kTexelBytes);
    index_ = SceneIndex(blocks, std::min(scene::kChunkBytes, possible.pageBytes));
    places_.resize(index_.chunks.size());
    if (bytesOf(index_) <= memory.budgetBytes)
        holdAll(device, blocks, possible);
    else
        holdSome(device, blocks, possible);
}

void GpuScene::holdAll(const Device& device, std::span<const scene::TileBlock> blocks, const SceneMemory& memory) {
    const std::uint32_t room = static_cast<std::uint32_t>(memory.pageBytes / kTexelBytes) / 2 * 2;
    std::vector<std::uint32_t> pages;
    for (std::size_t i = 0; i < places_.size(); ++i) {
        const std::uint32_t texels = index_.chunks[i].texels();
        assert(texels <= room);
        if (pages.empty() || pages.back() + texels > room) pages.push_back(0);
        places_[i].page = static_cast<std::uint32_t>(pages.size() - 1);
        places_[i].firstTexel = pages.back();
        pages.back() += texels;
    }
    for (std::uint32_t& texels : pages)
        texels = std::max(texels, 2u); // a buffer cannot be empty; nothing ever reads this one
    pool_ = std::make_unique<TilePool>(device, pages, memory.isStaged);
    std::vector<std::uint32_t> all(places_.size());
    std::iota(all.begin(), all.end(), 0u);
    fill(device, blocks, all);
}

void GpuScene::holdSome(const Device& device, std::span<const scene::TileBlock> blocks, const SceneMemory& memory) {
    index_.findFiner();
    const std::vector<std::uint32_t> kept = chunksToKeep(index_, memory.budgetBytes);
    for (const std::uint32_t chunk : kept)
        bytesKept_ += index_.chunks[chunk].chunk.bytes();
    constexpr std::size_t kLeastChunks = 4; // that come and go
    if (bytesKept_ + kLeastChunks * scene::kChunkBytes > memory.budgetBytes)
        throw OutOfMemory("needs at least " + mebibytes(bytesKept_ + kLeastChunks * scene::kChunkBytes, true) +
                              " to show the coarsest of everything, but may take " +
                              mebibytes(memory.budgetBytes, false) + " of its " + mebibytes(bytesOf(index_), true),
                          std::string("the scene"), "allow more with --memory, on a device that has it");
    std::vector<std::uint32_t> pages(memory.budgetBytes / memory.pageBytes,
                                     static_cast<std::uint32_t>(memory.pageBytes / kTexelBytes) / 2 * 2);
    const std::size_t rest = memory.budgetBytes % memory.pageBytes;
    if (rest >= scene::kChunkBytes) pages.push_back(static_cast<std::uint32_t>(rest / kTexelBytes) / 2 * 2);
    std::vector<RangeAllocator> free;
    for (const std::uint32_t texels : pages)
        free.emplace_back(texels);
    for (const std::uint32_t chunk : kept) {
        const std::uint32_t texels = index_.chunks[chunk].texels();
        std::optional<std::uint32_t> first;
        for (std::uint32_t page = 0; page < free.size() && !first; ++page)
            if ((first = free[page].take(texels))) places_[chunk] = {page, *first, false};
        if (first) continue;
        // What is kept must be there, even if the ends of pages took what was left.
        pages.push_back(static_cast<std::uint32_t>(std::min(memory.pageBytes, 8 * scene::kChunkBytes) / kTexelBytes));
        free.emplace_back(pages.back());
        places_[chunk] = {static_cast<std::uint32_t>(pages.size() - 1), free.back().take(texels).value(), false};
    }
    pool_ = std::make_unique<TilePool>(device, pages, memory.isStaged);
    fill(device, blocks, kept);
    stream_ = std::make_unique<TileStream>(device, index_, blocks, *pool_, kept, std::move(free));
}

void GpuScene::fill(const Device& device, std::span<const scene::TileBlock> blocks,
                    std::span<const std::uint32_t> chunks) {
    std::vector<TilePool::Part> parts;
    for (const std::uint32_t chunk : chunks)
        parts.push_back({places_[chunk], index_.chunks[chunk].texels()});
    pool_->fill(device, parts, [&](std::size_t i, std::byte* bytes) {
        const IndexedChunk& chunk = index_.chunks[chunks[i]];
        places_[chunks[i]].isDamaged = !bringChunk(blocks[chunk.captured], chunk, bytes);
    });
    for (const std::uint32_t chunk : chunks)
        if (places_[chunk].isDamaged) damaged_.push_back(chunk);
}

std::vector<std::uint32_t> GpuScene::takeDamaged() {
    std::vector<std::uint32_t> damaged = std::exchange(damaged_, {});
    if (stream_) {
        const std::vector<std::uint32_t> further = stream_->takeDamaged();
        damaged.insert(damaged.end(), further.begin(), further.end());
    }
    return damaged;
}

} // namespace render
