#include "scene/scene_file.h"

#include "scene/errors.h"
#include "scene/pyramid.h"
#include "scene/tile_chunks.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <mutex>

#include <nlohmann/json.hpp>

#include <tbb/parallel_for.h>

#include <xxhash.h>

namespace scene {

namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "tiles.bin is little-endian and mapped as it is");

constexpr std::array<char, 8> kMagic{'R', 'V', 'T', 'I', 'L', 'E', 'S', 0};
constexpr std::uint32_t kVersion = 5, kByteOrderMark = 0x01020304;
constexpr std::uint64_t kAlignment = 64;
constexpr const char* kRemedy = "the scene is damaged: build it again";

struct FileHeader {
    std::array<char, 8> magic = kMagic;
    std::uint32_t version = kVersion, byteOrderMark = kByteOrderMark;
    std::uint64_t blockCount = 0, fileSize = 0;
    std::array<std::uint64_t, 3> reserved{};
    std::uint64_t checksum = 0; ///< of all before it
};
static_assert(sizeof(FileHeader) == 64);

struct BlockEntry {
    std::uint64_t offset = 0;
    std::uint32_t tileCount = 0, coarserCount = 0, vertexCount = 0, quadCount = 0, facetCount = 0, texelCount = 0;
    std::uint32_t chunkCount = 0, reserved = 0;
    std::uint64_t checksum = 0; ///< of the tiles and the checksums of chunks
};
static_assert(sizeof(BlockEntry) == 48);

std::uint64_t checksumOf(std::span<const std::byte> bytes) {
    return XXH3_64bits(bytes.data(), bytes.size());
}

template <class T>
std::span<const std::byte> bytesOf(const T& value) {
    return std::as_bytes(std::span(&value, 1));
}

/// Of what is checked when the scene is opened.
std::uint64_t headBytes(const BlockEntry& entry) {
    return (std::uint64_t{entry.tileCount} + entry.coarserCount) * sizeof(Tile) +
           std::uint64_t{entry.chunkCount} * sizeof(std::uint64_t);
}

std::uint64_t blockBytes(const BlockEntry& entry) {
    return headBytes(entry) + std::uint64_t{entry.vertexCount} * sizeof(TileVertex) +
           std::uint64_t{entry.quadCount} * sizeof(TileQuad) + std::uint64_t{entry.facetCount} * sizeof(TileFacet) +
           std::uint64_t{entry.texelCount} * sizeof(TileTexel);
}

std::uint64_t aligned(std::uint64_t offset) {
    return (offset + kAlignment - 1) / kAlignment * kAlignment;
}

/// The arrays one after another behind `room` bytes for a head. All sizes are multiples of 8, and so are the
/// places.
std::vector<std::byte> blockOf(const TileSet& set, std::span<const std::uint64_t> chunkSums, std::size_t room) {
    const std::array parts{std::as_bytes(std::span(set.tiles)),
                           std::as_bytes(std::span(set.coarser)),
                           std::as_bytes(chunkSums),
                           std::as_bytes(std::span(set.vertices)),
                           std::as_bytes(std::span(set.quads)),
                           std::as_bytes(std::span(set.facets)),
                           std::as_bytes(std::span(set.texels))};
    std::size_t size = room;
    for (const auto& part : parts)
        size += part.size();
    std::vector<std::byte> bytes(size);
    std::byte* at = bytes.data() + room;
    for (const auto& part : parts)
        at = std::copy(part.begin(), part.end(), at);
    return bytes;
}

BlockEntry entryOf(const TileSet& set, std::uint64_t offset, std::size_t chunks, std::span<const std::byte> checked) {
    return {offset,
            static_cast<std::uint32_t>(set.tiles.size()),
            static_cast<std::uint32_t>(set.coarser.size()),
            static_cast<std::uint32_t>(set.vertices.size()),
            static_cast<std::uint32_t>(set.quads.size()),
            static_cast<std::uint32_t>(set.facets.size()),
            static_cast<std::uint32_t>(set.texels.size()),
            static_cast<std::uint32_t>(chunks),
            0,
            checksumOf(checked)};
}

/// Throws unless every index of a tile stays inside its block and every number is finite. What it holds is checked
/// with its chunk.
void checkTile(const TileBlock& block, const Tile& tile, const Camera& camera, const std::string& where) {
    const auto require = [&](bool holds, const char* what) {
        if (!holds) throw Failure(std::string("has a tile with ") + what, where, kRemedy);
    };
    require(std::isfinite(tile.minDisparity) && std::isfinite(tile.maxDisparity) && tile.minDisparity >= 0 &&
                tile.minDisparity <= tile.maxDisparity,
            "impossible disparities");
    const int maxSize = tile.placeBits == kPlaceBits ? kMaxTileSize : kMaxScrapSize;
    require(tile.placeBits == kPlaceBits || tile.placeBits == kScrapPlaceBits, "unknown coordinates");
    require(tile.width <= maxSize && tile.height <= maxSize && tile.x0 >= 0 && tile.y0 >= 0 &&
                tile.x0 <= camera.width - tile.width && tile.y0 <= camera.height - tile.height,
            "a place outside its image");
    require(static_cast<int>(tile.tier) < kTiers, "an unknown tier");
    require(std::uint64_t{tile.pointCount} + tile.loneCount <= tile.vertexCount && tile.loneCount <= tile.pointCount &&
                std::uint64_t{tile.firstVertex} + tile.vertexCount <= block.vertices.size() &&
                std::uint64_t{tile.firstQuad} + tile.quadCount <= block.quads.size() &&
                std::uint64_t{tile.firstFacet} + tile.facetCount <= block.facets.size() &&
                std::uint64_t{tile.firstTexel} + texelCountOf(tile) <= block.texels.size(),
            "counts beyond its block");
}

/// Throws unless the heads of the tiles may be trusted blindly.
void checkBlock(const TileBlock& block, const std::string& where) {
    for (const Tile& tile : block.tiles) {
        if (tile.level != 0) throw Failure("has a tile of a wrong level", where, kRemedy);
        checkTile(block, tile, block.camera, where);
    }
    int level = 1;
    for (const Tile& tile : block.coarser) {
        if (tile.level < level || tile.level >= kMaxLevels)
            throw Failure("has a tile of a wrong level", where, kRemedy);
        level = tile.level;
        checkTile(block, tile, cameraAtLevel(block.camera, level), where);
    }
    if (chunksOf(block).size() != block.chunkSums.size()) throw Failure("has a wrong number of chunks", where, kRemedy);
}

TileBlock lendBlock(std::span<const std::byte> bytes, const BlockEntry& entry, const Camera& camera,
                    const Pose& worldFromCamera) {
    const std::byte* at = bytes.data();
    const auto next = [&]<class T>(std::span<const T>& part, std::uint32_t count) {
        part = {reinterpret_cast<const T*>(at), count};
        at += count * sizeof(T);
    };
    TileBlock block{camera, worldFromCamera, {}, {}, {}, {}, {}, {}, {}, nullptr, true};
    next(block.tiles, entry.tileCount), next(block.coarser, entry.coarserCount);
    next(block.chunkSums, entry.chunkCount);
    next(block.vertices, entry.vertexCount), next(block.quads, entry.quadCount);
    next(block.facets, entry.facetCount), next(block.texels, entry.texelCount);
    return block;
}

std::vector<BlockEntry> readTable(std::span<const std::byte> file, const std::filesystem::path& path,
                                  std::size_t blockCount) {
    if (file.size() < sizeof(FileHeader)) throw Failure("is cut off in its header", path, kRemedy);
    FileHeader header;
    std::memcpy(&header, file.data(), sizeof header);
    if (header.magic != kMagic) throw Failure("is not a file of tiles", atByte(path, 0), kRemedy);
    if (header.version != kVersion)
        throw Failure("is of version " + std::to_string(header.version) + ", not " + std::to_string(kVersion),
                      atByte(path, 8), "build the scene again with this Revisit");
    if (header.byteOrderMark != kByteOrderMark || header.checksum != checksumOf(bytesOf(header).first(56)))
        throw Failure("has a damaged header", atByte(path, 12), kRemedy);
    if (header.fileSize != file.size())
        throw Failure("has " + std::to_string(file.size()) + " bytes instead of " + std::to_string(header.fileSize),
                      path, kRemedy);
    if (header.blockCount != blockCount)
        throw Failure("holds " + std::to_string(header.blockCount) + " blocks but scene.json lists " +
                          std::to_string(blockCount) + " images",
                      path, kRemedy);
    const std::uint64_t tableBytes = blockCount * sizeof(BlockEntry);
    if (sizeof header + tableBytes + sizeof(std::uint64_t) > file.size())
        throw Failure("is cut off in its table", atByte(path, sizeof header), kRemedy);
    std::vector<BlockEntry> table(blockCount);
    if (tableBytes > 0) std::memcpy(table.data(), file.data() + sizeof header, tableBytes);
    std::uint64_t checksum = 0;
    std::memcpy(&checksum, file.data() + sizeof header + tableBytes, sizeof checksum);
    if (checksum != checksumOf(std::as_bytes(std::span(table))))
        throw Failure("has a damaged table", atByte(path, sizeof header), kRemedy);
    for (const BlockEntry& entry : table)
        if (entry.offset % kAlignment != 0 || entry.offset > file.size() ||
            blockBytes(entry) > file.size() - entry.offset)
            throw Failure("has a block beyond its end", atByte(path, entry.offset), kRemedy);
    return table;
}

SceneImage readImage(const json& from) {
    SceneImage image{from.at("name").get<std::string>(),
                     {from.at("width").get<int>(), from.at("height").get<int>(), from.at("fx").get<double>(),
                      from.at("fy").get<double>(), from.at("cx").get<double>(), from.at("cy").get<double>()},
                     {},
                     {}};
    glm::dmat4 matrix(0.0);
    for (int i = 0; i < 16; ++i)
        matrix[i % 4][i / 4] = from.at("world_from_camera").at(static_cast<std::size_t>(i)).get<double>();
    if (!isUsable(image.camera) || !poseFromMatrix(matrix, 1e-6, image.worldFromCamera))
        throw Failure("has a camera that is not usable", image.name, kRemedy);
    const json box = from.value("samples_in_world", json()); // scenes of before do not say
    if (!box.is_null()) {
        for (int axis = 0; axis < 3; ++axis) {
            image.samplesInWorld.least[axis] = box.at(static_cast<std::size_t>(axis)).get<double>();
            image.samplesInWorld.most[axis] = box.at(static_cast<std::size_t>(axis + 3)).get<double>();
            if (!(image.samplesInWorld.least[axis] <= image.samplesInWorld.most[axis]))
                throw Failure("has a box about its samples that is none", image.name, kRemedy);
        }
    }
    return image;
}

/// Whether there is a file of coverage beside it.
bool readManifest(Scene& scene, const std::filesystem::path& path) {
    std::ifstream file(path);
    if (!file) throw Failure("holds no scene.json", scene.folder, "name a folder that 'revisit build' made");
    scene.manifest.assign(std::istreambuf_iterator<char>(file), {});
    try {
        const json root = json::parse(scene.manifest);
        if (root.at("revisit") != "scene")
            throw Failure("is no scene", path, "name a folder that 'revisit build' made");
        if (root.at("version") != 1)
            throw Failure("is of another version", path, "build the scene again with this Revisit");
        for (const json& image : root.at("images"))
            scene.images.push_back(readImage(image));
        for (const json& image : root.at("held_out"))
            scene.heldOut.push_back(readImage(image));
        glm::dmat4 matrix(0.0);
        for (int i = 0; i < 16; ++i)
            matrix[i % 4][i / 4] = root.at("walk_from_world").at(static_cast<std::size_t>(i)).get<double>();
        if (!poseFromMatrix(matrix, 1e-6, scene.walkFromWorld))
            throw Failure("has no usable walk_from_world", path, kRemedy);
        scene.hasWholeImages = root.value("whole_images", false);
        return root.value("coverage", false);
    } catch (const json::parse_error& e) {
        throw Failure("is not valid JSON", atByte(path, e.byte), kRemedy);
    } catch (const json::exception& e) {
        throw Failure(std::string("lacks something or has it wrong (") + e.what() + ")", path, kRemedy);
    }
}

} // namespace

std::vector<std::byte> packTiles(const TileSet& tiles) {
    BlockEntry entry;
    std::vector<std::byte> packed = blockOf(tiles, {}, sizeof entry);
    entry = entryOf(tiles, 0, 0, std::span(packed).subspan(sizeof entry));
    std::memcpy(packed.data(), &entry, sizeof entry);
    return packed;
}

TileSet unpackTiles(std::span<const std::byte> packed, const std::string& where) {
    BlockEntry entry;
    if (packed.size() < sizeof entry) throw Failure("is cut off", where, kRemedy);
    std::memcpy(&entry, packed.data(), sizeof entry);
    const std::span<const std::byte> bytes = packed.subspan(sizeof entry);
    if (entry.chunkCount != 0 || blockBytes(entry) != bytes.size() || checksumOf(bytes) != entry.checksum)
        throw Failure("is damaged", where, kRemedy);
    TileSet set;
    set.tiles.resize(entry.tileCount), set.coarser.resize(entry.coarserCount);
    set.vertices.resize(entry.vertexCount), set.quads.resize(entry.quadCount);
    set.facets.resize(entry.facetCount), set.texels.resize(entry.texelCount);
    auto copy = [at = bytes.data()](auto& array) mutable {
        const std::size_t size = array.size() * sizeof(array[0]);
        if (size > 0) std::memcpy(array.data(), at, size);
        at += size;
    };
    copy(set.tiles), copy(set.coarser), copy(set.vertices), copy(set.quads), copy(set.facets), copy(set.texels);
    return set;
}

void writeTilesFile(const std::filesystem::path& path, std::size_t blockCount,
                    const std::function<TileSet(std::size_t)>& tilesOf) {
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    std::vector<BlockEntry> table(blockCount);
    const std::uint64_t dataStart =
        aligned(sizeof(FileHeader) + blockCount * sizeof(BlockEntry) + sizeof(std::uint64_t));
    std::uint64_t offset = dataStart;
    const auto put = [&](std::span<const std::byte> bytes) {
        file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    };
    const std::vector<std::byte> zeros(dataStart);
    put(zeros);
    for (std::size_t i = 0; i < blockCount; ++i) {
        const TileSet set = tilesOf(i);
        const TileBlock lent = lend(set, {}, {});
        std::vector<std::uint64_t> chunkSums;
        for (const TileChunk& chunk : chunksOf(lent))
            chunkSums.push_back(checksumOf(lent, chunk));
        const std::vector<std::byte> block = blockOf(set, chunkSums, 0);
        table[i] = entryOf(set, offset, chunkSums.size(), {});
        table[i].checksum = checksumOf(std::span(block).first(headBytes(table[i])));
        put(block);
        offset += block.size();
        put(std::span(zeros).first(aligned(offset) - offset));
        offset = aligned(offset);
    }
    FileHeader header;
    header.blockCount = blockCount;
    header.fileSize = offset;
    header.checksum = checksumOf(bytesOf(header).first(56));
    const std::uint64_t tableChecksum = checksumOf(std::as_bytes(std::span(table)));
    file.seekp(0);
    put(bytesOf(header));
    put(std::as_bytes(std::span(table)));
    put(bytesOf(tableChecksum));
    file.close();
    if (!file) throw Failure("cannot be written", path, "check that the disk has room and the folder may be written");
}

Scene openScene(const std::filesystem::path& folder, DamagedHeads heads) {
    Scene scene;
    scene.folder = folder;
    std::error_code ignored;
    if (!std::filesystem::is_directory(folder, ignored))
        throw Failure("no such scene folder", folder, "name a folder that 'revisit build' made");
    const bool hasCoverage = readManifest(scene, folder / "scene.json");
    const std::filesystem::path tilesPath = folder / "tiles.bin";
    scene.tilesFile = MappedFile(tilesPath);
    const std::span<const std::byte> file = scene.tilesFile.bytes();
    const std::vector<BlockEntry> table = readTable(file, tilesPath, scene.images.size());
    scene.blocks.resize(table.size());
    scene.verdicts.resize(table.size());
    std::mutex mutex;
    tbb::parallel_for(std::size_t{0}, table.size(), [&](std::size_t i) {
        const BlockEntry& entry = table[i];
        const std::span<const std::byte> bytes = file.subspan(entry.offset, blockBytes(entry));
        const std::string where = atByte(tilesPath, entry.offset);
        if (checksumOf(bytes.first(headBytes(entry))) != entry.checksum) {
            if (heads == DamagedHeads::refused)
                throw Failure("has a damaged block (" + scene.images[i].name + ")", where, kRemedy);
            scene.blocks[i] = lendBlock({}, {}, scene.images[i].camera, scene.images[i].worldFromCamera);
            const std::scoped_lock lock(mutex);
            scene.damaged.push_back(i);
            return;
        }
        scene.blocks[i] = lendBlock(bytes, entry, scene.images[i].camera, scene.images[i].worldFromCamera);
        checkBlock(scene.blocks[i], where);
        scene.verdicts[i] = std::make_unique<std::atomic<std::uint8_t>[]>(entry.chunkCount);
        scene.blocks[i].verdicts = scene.verdicts[i].get();
        scene.blocks[i].samplesInWorld = scene.images[i].samplesInWorld;
    });
    std::sort(scene.damaged.begin(), scene.damaged.end());
    if (hasCoverage) scene.coverage = readCoverage(folder / kCoverageFile);
    return scene;
}

} // namespace scene
