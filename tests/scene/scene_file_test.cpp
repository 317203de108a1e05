#include "scene/scene_file.h"

#include "scene/errors.h"
#include "scene/tile_chunks.h"
#include "tests/scene/scratch_folder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <xxhash.h>

namespace scene {
namespace {

using nlohmann::json;

// The layout as the head of scene_file.h has it; written once more, so that a change of it is noticed.
constexpr std::size_t kHeaderBytes = 64, kHeaderChecked = 56, kEntryBytes = 48, kVersionAt = 8, kBlockCountAt = 16;
constexpr std::size_t kEntryTilesAt = 8, kEntryCoarserAt = 12, kEntryVerticesAt = 16, kEntryQuadsAt = 20,
                      kEntryFacetsAt = 24, kEntryTexelsAt = 28, kEntryChunksAt = 32, kEntryChecksumAt = 40;

/// A slope with a hole and a redundant corner; `step` makes one unlike the other.
DepthImage drawImage(const std::string& name, float step) {
    DepthImage image;
    image.name = name;
    image.camera = {9, 7, 8.0, 8.0, 4.5, 3.5};
    image.colour = Image<Rgb8>(9, 7, {200, 100, 50});
    image.disparity = Image<float>(9, 7);
    image.flags = Image<std::uint8_t>(9, 7);
    for (int y = 0; y < 7; ++y)
        for (int x = 0; x < 9; ++x)
            image.disparity(x, y) = 0.5f + step * static_cast<float>(x + y);
    image.flags(4, 3) = kNoSurface;
    image.flags(0, 0) = image.flags(1, 0) = kRedundant;
    image.flags(8, 6) = kDirectional;
    return image;
}

bool isSame(std::span<const Tile> tiles, std::span<const TileVertex> vertices, std::span<const TileQuad> quads,
            const TileSet& set) {
    return std::ranges::equal(tiles, set.tiles) && std::ranges::equal(vertices, set.vertices) &&
           std::ranges::equal(quads, set.quads);
}

template <class T>
T valueAt(const std::string& bytes, std::size_t at) {
    T value{};
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

template <class T>
void setValue(std::string& bytes, std::size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
}

/// A scene of two small images and one held out, on disk.
class SceneFile : public testing::Test {
  protected:
    void SetUp() override {
        const std::array images{drawImage("first", 0.02f), drawImage("second", 0.03f)};
        json listed = json::array();
        for (const DepthImage& image : images) {
            sets_.push_back(cutIntoTiles(image, 4));
            const Camera& c = image.camera;
            listed.push_back({{"name", image.name},
                              {"width", c.width},
                              {"height", c.height},
                              {"fx", c.fx},
                              {"fy", c.fy},
                              {"cx", c.cx},
                              {"cy", c.cy},
                              {"world_from_camera", {1, 0, 0, 1.5, 0, 1, 0, 2.5, 0, 0, 1, 3.5, 0, 0, 0, 1}}});
        }
        const json manifest{{"revisit", "scene"},
                            {"version", 1},
                            {"images", listed},
                            {"held_out", json::array({listed[0]})},
                            {"walk_from_world", {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1}}};
        manifest_ = manifest.dump();
        writeFile(folder() / "scene.json", manifest_);
        writeTilesFile(tilesPath(), sets_.size(), [&](std::size_t i) { return sets_[i]; });
        tiles_ = bytesOfFile(tilesPath());
    }

    const std::filesystem::path& folder() const { return scratch_.path(); }
    std::filesystem::path tilesPath() const { return folder() / "tiles.bin"; }

    bool isWhole(const Scene& scene) const {
        bool same = scene.blocks.size() == sets_.size();
        for (std::size_t i = 0; same && i < sets_.size(); ++i)
            same = isSame(scene.blocks[i].tiles, scene.blocks[i].vertices, scene.blocks[i].quads, sets_[i]);
        return same;
    }

    /// What openScene says of these bytes, or SoundTiles of what the tiles hold; empty if both are content.
    std::string failureWithTiles(const std::string& bytes) const {
        writeFile(tilesPath(), bytes);
        return failureOf<Failure>([&] {
            const Scene scene = openScene(folder());
            for (const TileBlock& block : scene.blocks) {
                SoundTiles sound(block);
                for (std::size_t i = 0; i < block.tiles.size() + block.coarser.size(); ++i)
                    if (!sound.isSound(i)) throw Failure("is not sound", tilesPath(), "");
            }
        });
    }
    std::string failureWithManifest(const std::string& text) const {
        writeFile(folder() / "scene.json", text);
        return failureOf<Failure>([&] { openScene(folder()); });
    }

    std::size_t tableEnd() const { return kHeaderBytes + sets_.size() * kEntryBytes; }
    std::size_t blockAt(std::size_t block) const {
        return valueAt<std::uint64_t>(tiles_, kHeaderBytes + block * kEntryBytes);
    }

    /// With checksums that agree with what was changed: only what stands in the bytes can then be wrong.
    std::string sealed(std::string bytes) const {
        for (std::size_t i = 0; i < sets_.size(); ++i) {
            const std::size_t entry = kHeaderBytes + i * kEntryBytes;
            const TileSet& set = sets_[i];
            const std::size_t size = (set.tiles.size() + set.coarser.size()) * sizeof(Tile) +
                                     valueAt<std::uint32_t>(tiles_, entry + kEntryChunksAt) * sizeof(std::uint64_t);
            setValue(bytes, entry + kEntryChecksumAt, XXH3_64bits(bytes.data() + blockAt(i), size));
        }
        setValue(bytes, tableEnd(), XXH3_64bits(bytes.data() + kHeaderBytes, tableEnd() - kHeaderBytes));
        setValue(bytes, kHeaderChecked, XXH3_64bits(bytes.data(), kHeaderChecked));
        return bytes;
    }

    ScratchFolder scratch_;
    std::vector<TileSet> sets_;
    std::string manifest_, tiles_;
};

TEST(PackedTiles, ComeBack) {
    const TileSet set = cutIntoTiles(drawImage("image", 0.02f), 4);
    ASSERT_GT(set.tiles.size(), 3u);
    ASSERT_GT(set.quads.size(), 10u);
    const TileSet back = unpackTiles(packTiles(set), "block");
    EXPECT_TRUE(isSame(back.tiles, back.vertices, back.quads, set));
    const TileSet nothing = unpackTiles(packTiles({}), "block");
    EXPECT_TRUE(nothing.tiles.empty() && nothing.vertices.empty() && nothing.quads.empty());
}

TEST(PackedTiles, AnyFlippedBitIsRefusedOrMeansNothing) {
    const TileSet set = cutIntoTiles(drawImage("image", 0.02f), 4);
    const std::vector<std::byte> packed = packTiles(set);
    std::size_t refused = 0;
    for (std::size_t at = 0; at < packed.size(); ++at)
        for (const int bit : {0, 4, 7}) {
            std::vector<std::byte> damaged = packed;
            damaged[at] ^= std::byte{1} << bit;
            TileSet back;
            const std::string failure = failureOf<Failure>([&] { back = unpackTiles(damaged, "this block"); });
            refused += failure.empty() ? 0 : 1;
            if (failure.empty()) {
                EXPECT_TRUE(isSame(back.tiles, back.vertices, back.quads, set)) << "byte " << at;
                EXPECT_LT(at, kEntryBytes) << "only a head has bytes without meaning";
            } else {
                EXPECT_EQ(failure.find("this block: "), 0u) << failure;
            }
        }
    EXPECT_GE(refused, 3 * (packed.size() - 12)) << "of the head, the offset and four bytes kept free mean nothing";
}

TEST(PackedTiles, AnyOtherLengthIsRefused) {
    std::vector<std::byte> packed = packTiles(cutIntoTiles(drawImage("image", 0.02f), 4));
    for (std::size_t size = 0; size < packed.size(); ++size)
        EXPECT_NE(failureOf<Failure>([&] { unpackTiles(std::span(packed).first(size), "block"); }), "") << size;
    packed.push_back({});
    EXPECT_NE(failureOf<Failure>([&] { unpackTiles(packed, "block"); }), "") << "a byte too many";
}

TEST(PackedTiles, HugeCountsTakeNoMemory) {
    const std::vector<std::byte> packed = packTiles(cutIntoTiles(drawImage("image", 0.02f), 4));
    for (const std::size_t at :
         {kEntryTilesAt, kEntryCoarserAt, kEntryVerticesAt, kEntryQuadsAt, kEntryFacetsAt, kEntryTexelsAt}) {
        std::vector<std::byte> damaged = packed;
        for (std::size_t i = 0; i < 4; ++i)
            damaged[at + i] = std::byte{0xff};
        EXPECT_NE(failureOf<Failure>([&] { unpackTiles(damaged, "block"); }), "") << "count at " << at;
    }
}

TEST_F(SceneFile, ComesBack) {
    const Scene scene = openScene(folder());
    EXPECT_TRUE(isWhole(scene));
    ASSERT_EQ(scene.images.size(), 2u);
    EXPECT_EQ(scene.images[1].name, "second");
    EXPECT_EQ(scene.images[1].camera, (Camera{9, 7, 8.0, 8.0, 4.5, 3.5}));
    EXPECT_EQ(scene.images[1].worldFromCamera.translation, glm::dvec3(1.5, 2.5, 3.5));
    ASSERT_EQ(scene.heldOut.size(), 1u);
    EXPECT_EQ(scene.heldOut[0].name, "first");
    EXPECT_EQ(scene.walkFromWorld * glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1));
    EXPECT_EQ(scene.manifest, manifest_);
}

TEST_F(SceneFile, BoxesAboutSamplesComeWithTheirBlocks) {
    EXPECT_FALSE(openScene(folder()).blocks[1].samplesInWorld.isFinite()) << "scenes of before do not say";
    json manifest = json::parse(manifest_);
    manifest["images"][1]["samples_in_world"] = {-1.5, 2, 3, 4, 5.25, 6};
    manifest["images"][0]["samples_in_world"] = nullptr;
    writeFile(folder() / "scene.json", manifest.dump());
    const Scene scene = openScene(folder());
    EXPECT_FALSE(scene.blocks[0].samplesInWorld.isFinite());
    EXPECT_EQ(scene.blocks[1].samplesInWorld.least, glm::dvec3(-1.5, 2, 3));
    EXPECT_EQ(scene.blocks[1].samplesInWorld.most, glm::dvec3(4, 5.25, 6));
}

TEST_F(SceneFile, WhatIsGivenBackIsReadAgain) {
    const Scene scene = openScene(folder());
    for (const TileBlock& block : scene.blocks) {
        EXPECT_TRUE(block.isMapped);
        for (const TileChunk& chunk : chunksOf(block))
            releaseChunk(block, chunk);
    }
    EXPECT_TRUE(isWhole(scene));
}

TEST_F(SceneFile, AnyFlippedBitOfTheTilesIsRefusedOrLiesBetweenBlocks) {
    std::size_t unnoticed = 0;
    for (std::size_t at = 0; at < tiles_.size(); ++at) {
        std::string damaged = tiles_;
        damaged[at] = static_cast<char>(damaged[at] ^ (1 << at % 8));
        const std::string failure = failureWithTiles(damaged);
        if (failure.empty()) {
            ++unnoticed;
            EXPECT_TRUE(isWhole(openScene(folder()))) << "byte " << at;
            EXPECT_EQ(tiles_[at], 0) << "byte " << at << " is no padding";
            EXPECT_GE(at, tableEnd() + sizeof(std::uint64_t)) << "header and table have no padding";
        } else {
            EXPECT_EQ(failure.find(tilesPath().string()), 0u) << failure;
        }
    }
    // The gap behind the table and one behind each block, each shorter than 64 bytes.
    EXPECT_LT(unnoticed, (sets_.size() + 1) * 64);
}

TEST_F(SceneFile, WhereItIsAskedForOnlyTheImageOfADamagedHeadIsMissing) {
    std::string damaged = tiles_;
    const std::size_t at = blockAt(1) + 5;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x40);
    EXPECT_NE(failureWithTiles(damaged).find("has a damaged block (second)"), std::string::npos);
    const Scene scene = openScene(folder(), DamagedHeads::leftOut);
    EXPECT_EQ(scene.damaged, std::vector<std::size_t>{1});
    EXPECT_TRUE(scene.blocks[1].tiles.empty() && scene.blocks[1].coarser.empty() && scene.blocks[1].vertices.empty());
    EXPECT_EQ(scene.blocks[1].camera, scene.images[1].camera);
    EXPECT_TRUE(isSame(scene.blocks[0].tiles, scene.blocks[0].vertices, scene.blocks[0].quads, sets_[0]));
    writeFile(tilesPath(), tiles_);
    EXPECT_TRUE(openScene(folder(), DamagedHeads::leftOut).damaged.empty());
}

TEST_F(SceneFile, TilesOfAnyOtherLengthAreRefused) {
    for (std::size_t size = 0; size < tiles_.size(); ++size)
        EXPECT_NE(failureWithTiles(tiles_.substr(0, size)), "") << size;
    EXPECT_NE(failureWithTiles(tiles_ + '\0'), "");
    std::filesystem::remove(tilesPath());
    EXPECT_NE(failureOf<Failure>([&] { openScene(folder()); }).find("tiles.bin"), std::string::npos);
    std::filesystem::create_directory(tilesPath());
    EXPECT_NE(failureOf<Failure>([&] { openScene(folder()); }).find("tiles.bin"), std::string::npos);
}

TEST_F(SceneFile, ImpossibleCountsWithRightChecksumsAreRefused) {
    ASSERT_EQ(failureWithTiles(sealed(tiles_)), "") << "the test's own checksums";
    const auto refused = [&](std::size_t at, auto value, const char* cause) {
        std::string damaged = tiles_;
        setValue(damaged, at, value);
        const std::string failure = failureWithTiles(sealed(damaged));
        EXPECT_NE(failure.find(cause), std::string::npos) << "at " << at << ": " << failure;
    };
    constexpr auto kMost32 = std::numeric_limits<std::uint32_t>::max();
    refused(kVersionAt, std::uint32_t{3}, "version 3");
    for (const std::uint64_t count : {std::uint64_t{1}, std::uint64_t{3}, std::uint64_t{1} << 59, ~std::uint64_t{0}})
        refused(kBlockCountAt, count, "blocks but scene.json lists 2");
    for (const std::size_t entry : {kHeaderBytes, kHeaderBytes + kEntryBytes}) {
        for (const std::uint64_t offset : {std::uint64_t{64} << 40, ~std::uint64_t{63}, std::uint64_t{1}})
            refused(entry, offset, "beyond its end");
        for (const std::size_t at : {kEntryTilesAt, kEntryCoarserAt, kEntryVerticesAt, kEntryQuadsAt, kEntryFacetsAt,
                                     kEntryTexelsAt, kEntryChunksAt})
            refused(entry + at, kMost32, "beyond its end");
    }
}

TEST_F(SceneFile, ImpossibleTilesWithRightChecksumsAreRefused) {
    const auto refused = [&](const char* cause, const std::function<void(Tile&)>& change) {
        std::string damaged = tiles_;
        Tile tile = valueAt<Tile>(damaged, blockAt(1));
        change(tile);
        setValue(damaged, blockAt(1), tile);
        const std::string failure = failureWithTiles(sealed(damaged));
        EXPECT_NE(failure.find(cause), std::string::npos) << failure;
    };
    constexpr auto kMost = std::numeric_limits<std::int32_t>::max();
    constexpr auto kMost32 = std::numeric_limits<std::uint32_t>::max();
    const auto at = [&](auto Tile::*member, auto value) { return [=](Tile& tile) { tile.*member = value; }; };
    for (const float bad : {std::nanf(""), INFINITY, -1.0f})
        refused("impossible disparities", at(&Tile::maxDisparity, bad));
    refused("impossible disparities", at(&Tile::minDisparity, std::nanf("")));
    for (const std::int32_t bad : {-1, 9, kMost, std::numeric_limits<std::int32_t>::min()}) {
        refused("outside its image", at(&Tile::x0, bad));
        refused("outside its image", at(&Tile::y0, bad));
    }
    refused("outside its image", at(&Tile::width, std::uint8_t{255}));
    refused("outside its image", at(&Tile::height, std::uint8_t{64}));
    refused("unknown tier", at(&Tile::tier, static_cast<Tier>(kTiers)));
    refused("beyond its block", at(&Tile::firstVertex, kMost32));
    refused("beyond its block", at(&Tile::vertexCount, kMost32));
    refused("beyond its block", at(&Tile::pointCount, kMost32));
    refused("beyond its block", at(&Tile::loneCount, std::uint16_t{65535}));
    refused("beyond its block", at(&Tile::firstQuad, kMost32));
    refused("beyond its block", at(&Tile::quadCount, kMost32));
    refused("number of chunks", [](Tile& tile) { tile.vertexCount = tile.pointCount = 0; });
}

TEST_F(SceneFile, AnyFlippedBitOfTheManifestIsRefusedOrStillAScene) {
    std::size_t refused = 0;
    for (std::size_t at = 0; at < manifest_.size(); ++at) {
        std::string damaged = manifest_;
        damaged[at] = static_cast<char>(damaged[at] ^ (1 << at % 8));
        const std::string failure = failureWithManifest(damaged); // any other exception fails the test
        refused += failure.empty() ? 0 : 1;
        if (!failure.empty()) {
            EXPECT_EQ(failure.find('\n'), std::string::npos) << failure;
        }
    }
    // A digit may become another one; braces, quotes and names may not.
    EXPECT_GT(refused, manifest_.size() / 2);
}

TEST_F(SceneFile, ACutManifestIsRefused) {
    for (std::size_t size = 0; size < manifest_.size(); ++size)
        EXPECT_NE(failureWithManifest(manifest_.substr(0, size)).find("scene.json"), std::string::npos) << size;
}

TEST_F(SceneFile, AManifestOfOtherTypesIsRefused) {
    const auto refused = [&](const char* pointer, const json& value) {
        json manifest = json::parse(manifest_);
        manifest[json::json_pointer(pointer)] = value;
        EXPECT_NE(failureWithManifest(manifest.dump()), "") << pointer << " = " << value;
    };
    for (const char* text : {"", "null", "[]", "7", "\"scene\"", "{}", "[[[[", "{\"revisit\": 1e999}", "\xff"})
        EXPECT_NE(failureWithManifest(text), "") << text;
    refused("/revisit", "capture");
    refused("/version", 2);
    refused("/images", json::array());
    refused("/images", "all");
    refused("/images/0", 7);
    refused("/images/0/name", 7);
    for (const json& bad : {json(0), json(-9), json("wide"), json(nullptr), json::array({9})})
        refused("/images/1/width", bad);
    for (const json& bad : {json(0), json(-1.5), json("far"), json(nullptr)})
        refused("/images/1/fx", bad);
    refused("/images/0/world_from_camera", {1, 0, 0});
    refused("/images/0/world_from_camera/0", 2);
    refused("/images/0/world_from_camera/15", 0);
    refused("/images/0/world_from_camera/3", "east");
    refused("/images/0/samples_in_world", {0, 0, 0, 1, 1});
    refused("/images/0/samples_in_world", "everywhere");
    refused("/images/0/samples_in_world", {0, 0, 2, 1, 1, 1});
    refused("/images/0/samples_in_world", {0, 0, nullptr, 1, 1, 1});
    refused("/held_out", 1);
    refused("/held_out/0/height", 0);
    refused("/walk_from_world/0", -1);
    refused("/walk_from_world", json::array());
}

} // namespace
} // namespace scene
