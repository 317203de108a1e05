#include "scene/tile_chunks.h"

#include "scene/pyramid.h"
#include "scene/scene_file.h"

#include <cstring>

#include <gtest/gtest.h>

namespace scene {
namespace {

/// Two slopes with a step between them, a part of them redundant or directional.
DepthImage drawImage() {
    DepthImage image;
    image.camera = {200, 150, 150.0, 150.0, 100, 75};
    image.colour = Image<Rgb8>(200, 150, {200, 100, 50});
    image.disparity = Image<float>(200, 150);
    image.flags = Image<std::uint8_t>(200, 150);
    for (int y = 0; y < 150; ++y)
        for (int x = 0; x < 200; ++x) {
            image.disparity(x, y) = (x < 90 ? 0.5f : 0.9f) + 0.0002f * static_cast<float>(x + y);
            if (y > 100) image.flags(x, y) = kDirectional;
            if (x > 150) image.flags(x, y) = kRedundant;
        }
    return image;
}

class TileChunks : public testing::Test {
  protected:
    TileSet set_ = cutIntoLevels(drawImage(), {});
    TileBlock block_ = lend(set_, drawImage().camera, {});
};

TEST_F(TileChunks, HoldEveryTileOnceAndAllOfIt) {
    for (const std::size_t most : {std::size_t{1}, std::size_t{20000}, kChunkBytes}) {
        std::size_t tile = 0, vertices = 0, quads = 0, facets = 0, texels = 0;
        for (const TileChunk& chunk : chunksOf(block_, most)) {
            ASSERT_EQ(chunk.firstTile, tile);
            for (std::size_t i = tile; i < tile + chunk.tileCount; ++i) {
                EXPECT_EQ(tileOf(block_, i).tier, chunk.tier);
                EXPECT_EQ(tileOf(block_, i).level, chunk.level);
            }
            EXPECT_TRUE(chunk.tileCount == 1 || chunk.bytes() <= most);
            tile += chunk.tileCount, vertices += chunk.vertexCount, quads += chunk.quadCount;
            facets += chunk.facetCount, texels += chunk.texelCount;
        }
        EXPECT_EQ(tile, set_.tiles.size() + set_.coarser.size());
        EXPECT_EQ(vertices, set_.vertices.size());
        EXPECT_EQ(quads, set_.quads.size());
        EXPECT_EQ(facets, set_.facets.size());
        EXPECT_EQ(texels, set_.texels.size());
    }
    ASSERT_GT(set_.facets.size(), 0u);
    EXPECT_GT(chunksOf(block_).size(), 5u) << "tiers and levels never share one";
}

TEST_F(TileChunks, AreCopiedPartByPart) {
    for (const TileChunk& chunk : chunksOf(block_, 20000)) {
        std::vector<std::byte> bytes(chunk.bytes());
        copyChunk(block_, chunk, bytes.data());
        const std::size_t vertexAt = chunk.facetCount * sizeof(TileFacet);
        const Tile& last = tileOf(block_, chunk.firstTile + chunk.tileCount - 1);
        const std::size_t within = last.firstVertex - chunk.firstVertex;
        TileVertex vertex;
        std::memcpy(&vertex, bytes.data() + vertexAt + within * sizeof vertex, sizeof vertex);
        EXPECT_EQ(vertex, set_.vertices[last.firstVertex]);
        if (last.facetCount == 0) continue;
        TileFacet facet;
        std::memcpy(&facet, bytes.data() + (last.firstFacet - chunk.firstFacet) * sizeof facet, sizeof facet);
        EXPECT_EQ(facet, set_.facets[last.firstFacet]);
        TileTexel texel;
        std::memcpy(&texel, bytes.data() + bytes.size() - texelCountOf(last) * sizeof texel, sizeof texel);
        EXPECT_EQ(texel, set_.texels[last.firstTexel]);
    }
}

TEST_F(TileChunks, OneFlippedBitSpoilsItsOwnChunkAlone) {
    std::vector<std::uint64_t> sums;
    for (const TileChunk& chunk : chunksOf(block_))
        sums.push_back(checksumOf(block_, chunk));
    block_.chunkSums = sums;
    SoundTiles before(block_);
    for (std::size_t i = 0; i < set_.tiles.size() + set_.coarser.size(); ++i)
        ASSERT_TRUE(before.isSound(i));
    const Tile& tile = set_.tiles[set_.tiles.size() / 2];
    set_.vertices[tile.firstVertex].colour ^= 4u;
    const auto chunks = chunksOf(block_);
    std::size_t spoilt = 0;
    for (std::size_t i = 0; i < chunks.size(); ++i)
        spoilt += isSound(block_, chunks[i], i) ? 0 : 1;
    EXPECT_EQ(spoilt, 1u);
    SoundTiles after(block_);
    EXPECT_FALSE(after.isSound(set_.tiles.size() / 2));
}

TEST_F(TileChunks, IndicesThatLeadOutsideAreNotSoundEvenIfTheirSumIs) {
    const auto isSoundWith = [&] {
        std::vector<std::uint64_t> sums;
        const auto chunks = chunksOf(block_);
        for (const TileChunk& chunk : chunks)
            sums.push_back(checksumOf(block_, chunk));
        block_.chunkSums = sums;
        bool sound = true;
        for (std::size_t i = 0; i < chunks.size(); ++i)
            sound = sound && isSound(block_, chunks[i], i);
        block_.chunkSums = {};
        return sound;
    };
    ASSERT_TRUE(isSoundWith());
    const TileQuad quad = set_.quads[5];
    set_.quads[5].top |= kQuadIndexMask;
    EXPECT_FALSE(isSoundWith());
    set_.quads[5] = quad;
    const TileFacet facet = set_.facets[0];
    set_.facets[0].mark |= 63u;
    EXPECT_FALSE(isSoundWith());
    set_.facets[0] = facet;
    set_.facets[0].perX = NAN;
    EXPECT_FALSE(isSoundWith());
}

} // namespace
} // namespace scene
