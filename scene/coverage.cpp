#include "scene/coverage.h"

#include "scene/coverage_levels.h"
#include "scene/errors.h"
#include "scene/mapped_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <span>

#include <glm/common.hpp>
#include <xxhash.h>

namespace scene {

namespace {

static_assert(std::endian::native == std::endian::little, "coverage.bin is little-endian");

constexpr std::array<char, 8> kCoverageMagic{'R', 'V', 'C', 'O', 'V', 'E', 'R', 0};
constexpr std::uint32_t kCoverageVersion = 1, kCoverageByteOrder = 0x01020304;
constexpr const char* kBuildAgain = "the scene is damaged: build it again";

struct CoverageHeader {
    std::array<char, 8> magic = kCoverageMagic;
    std::uint32_t version = kCoverageVersion, byteOrderMark = kCoverageByteOrder;
    std::array<double, 3> corner{};
    double edge = 0;
    std::uint64_t nodeCount = 0, nodesChecksum = 0;
    std::uint64_t checksum = 0; ///< of all before it
};
static_assert(sizeof(CoverageHeader) == 72);

std::uint64_t bytesChecksum(std::span<const std::byte> bytes) {
    return XXH3_64bits(bytes.data(), bytes.size());
}

std::uint64_t headerChecksum(const CoverageHeader& header) {
    return bytesChecksum(std::as_bytes(std::span(&header, 1)).first(offsetof(CoverageHeader, checksum)));
}

/// Throws unless the nodes are one tree: a reader may then follow it blindly.
void checkNodes(const std::vector<CoverageNode>& nodes, const std::filesystem::path& path) {
    std::vector<std::uint8_t> level(nodes.size(), 0);
    level[0] = 1;
    std::size_t next = 1; // children of each node follow those of the node before
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const CoverageNode& node = nodes[i];
        const auto where = [&] { return atByte(path, sizeof(CoverageHeader) + i * sizeof(CoverageNode)); };
        if (((node.unseen | node.surface) & node.children) != 0 || (node.unseen & node.surface) != 0)
            throw Failure("has a cell of two kinds", where(), kBuildAgain);
        const auto count = static_cast<std::size_t>(std::popcount(node.children));
        if (count == 0) continue;
        if (level[i] == 0 || node.firstChild != next || count > nodes.size() - next)
            throw Failure("has a node whose children are not where they must be", where(), kBuildAgain);
        if (level[i] == kMaxCoverageLevels) throw Failure("has cells that are too small", where(), kBuildAgain);
        std::fill_n(level.begin() + static_cast<std::ptrdiff_t>(next), count, static_cast<std::uint8_t>(level[i] + 1));
        next += count;
    }
    if (next != nodes.size()) throw Failure("has nodes that belong to none", path, kBuildAgain);
}

/// Of a cell without children.
Observed observedOf(const CoverageNode& node, std::uint64_t mask) {
    return (node.unseen & mask) != 0    ? Observed::unseen
           : (node.surface & mask) != 0 ? Observed::surface
                                        : Observed::empty;
}

double volumeWithin(const glm::dvec3& corner, double edge, const glm::dvec3& low, const glm::dvec3& high) {
    const glm::dvec3 inside = glm::min(corner + edge, high) - glm::max(corner, low);
    return inside.x > 0 && inside.y > 0 && inside.z > 0 ? inside.x * inside.y * inside.z : 0;
}

void addVolumesWithin(const Coverage& coverage, std::size_t index, const glm::dvec3& corner, double edge,
                      const glm::dvec3& low, const glm::dvec3& high, std::array<double, 3>& volumes) {
    const CoverageNode& node = coverage.nodes[index];
    const double cell = edge / kCoverageBranching;
    for (int bit = 0; bit < 64; ++bit) {
        const glm::dvec3 first = corner + cell * glm::dvec3(bit % 4, bit / 4 % 4, bit / 16);
        const double volume = volumeWithin(first, cell, low, high);
        if (volume == 0) continue;
        const std::uint64_t mask = coverageMask(bit);
        if ((node.children & mask) != 0) {
            addVolumesWithin(coverage, node.firstChild + childRank(node.children, bit), first, cell, low, high,
                             volumes);
            continue;
        }
        volumes[static_cast<std::size_t>(observedOf(node, mask))] += volume;
    }
}

} // namespace

std::optional<CoverageCell> cellAt(const Coverage& coverage, const glm::dvec3& pInWorld) {
    double cell = coverage.edgeMetres / kCoverageBranching;
    glm::dvec3 corner = coverage.cornerInWorld;
    const glm::dvec3 inside = pInWorld - corner;
    for (int axis = 0; axis < 3; ++axis)
        if (!(inside[axis] >= 0 && inside[axis] < coverage.edgeMetres)) return std::nullopt;
    const CoverageNode* node = coverage.nodes.data();
    while (true) {
        std::array<int, 3> at{};
        for (int axis = 0; axis < 3; ++axis) {
            at[static_cast<std::size_t>(axis)] =
                std::clamp(static_cast<int>(std::floor((pInWorld[axis] - corner[axis]) / cell)), 0, 3);
            corner[axis] += at[static_cast<std::size_t>(axis)] * cell;
        }
        const int bit = coverageBit(at[0], at[1], at[2]);
        const std::uint64_t mask = coverageMask(bit);
        if ((node->children & mask) == 0) return CoverageCell{observedOf(*node, mask), corner, cell};
        node = &coverage.nodes[node->firstChild + childRank(node->children, bit)];
        cell /= kCoverageBranching;
    }
}

Observed observedAt(const Coverage& coverage, const glm::dvec3& pInWorld) {
    const std::optional<CoverageCell> cell = cellAt(coverage, pInWorld);
    return cell ? cell->observed : Observed::unseen;
}

std::array<double, 3> volumesOf(const Coverage& coverage, const glm::dvec3& low, const glm::dvec3& high) {
    std::array<double, 3> volumes{};
    addVolumesWithin(coverage, 0, coverage.cornerInWorld, coverage.edgeMetres, low, high, volumes);
    return volumes;
}

double finestCellOf(const Coverage& coverage) {
    return cellOfLevels(coverage, levelsOf(coverage));
}

void writeCoverage(const Coverage& coverage, const std::filesystem::path& path) {
    const std::span<const std::byte> nodes = std::as_bytes(std::span(coverage.nodes));
    const glm::dvec3& corner = coverage.cornerInWorld;
    CoverageHeader header;
    header.corner = {corner.x, corner.y, corner.z};
    header.edge = coverage.edgeMetres;
    header.nodeCount = coverage.nodes.size();
    header.nodesChecksum = bytesChecksum(nodes);
    header.checksum = headerChecksum(header);
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(&header), sizeof header);
    file.write(reinterpret_cast<const char*>(nodes.data()), static_cast<std::streamsize>(nodes.size()));
    file.close();
    if (!file) throw Failure("cannot be written", path, "check that the disk has room and the folder may be written");
}

Coverage readCoverage(const std::filesystem::path& path) {
    const MappedFile file(path);
    const std::span<const std::byte> bytes = file.bytes();
    if (bytes.size() < sizeof(CoverageHeader)) throw Failure("is cut off in its header", path, kBuildAgain);
    CoverageHeader header;
    std::memcpy(&header, bytes.data(), sizeof header);
    if (header.magic != kCoverageMagic) throw Failure("is not a file of coverage", atByte(path, 0), kBuildAgain);
    if (header.version != kCoverageVersion)
        throw Failure("is of version " + std::to_string(header.version) + ", not " + std::to_string(kCoverageVersion),
                      atByte(path, 8), "build the scene again with this Revisit");
    if (header.byteOrderMark != kCoverageByteOrder || header.checksum != headerChecksum(header))
        throw Failure("has a damaged header", atByte(path, 12), kBuildAgain);
    Coverage coverage;
    coverage.cornerInWorld = {header.corner[0], header.corner[1], header.corner[2]};
    coverage.edgeMetres = header.edge;
    if (!std::isfinite(header.corner[0]) || !std::isfinite(header.corner[1]) || !std::isfinite(header.corner[2]) ||
        !std::isfinite(header.edge) || header.edge <= 0)
        throw Failure("has an impossible place", atByte(path, 16), kBuildAgain);
    const std::span<const std::byte> nodes = bytes.subspan(sizeof header);
    if (header.nodeCount == 0 || nodes.size() % sizeof(CoverageNode) != 0 ||
        header.nodeCount != nodes.size() / sizeof(CoverageNode))
        throw Failure("has " + std::to_string(nodes.size()) + " bytes of nodes instead of " +
                          std::to_string(header.nodeCount) + " times " + std::to_string(sizeof(CoverageNode)),
                      path, kBuildAgain);
    if (header.nodesChecksum != bytesChecksum(nodes))
        throw Failure("has damaged nodes", atByte(path, sizeof header), kBuildAgain);
    coverage.nodes.resize(header.nodeCount);
    std::memcpy(coverage.nodes.data(), nodes.data(), nodes.size());
    checkNodes(coverage.nodes, path);
    return coverage;
}

} // namespace scene
