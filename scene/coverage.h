#pragma once
// Coverage: of any point of space, whether some image saw it empty, saw a surface there, or no image ever observed it.
// Nyland, McAllister, Popescu, McCue, Lastra: "Interactive exploration of acquired 3D data", 1999, section 4.4: skins
// bound the volumes that no ray pierced; here those volumes are kept themselves, in a sparse tree of cubes.
//
// A node is a cube of 4 x 4 x 4 cells; a cell is all of one kind, or a node of its own. Cells are as small as the
// images' samples stand apart where observed space ends in the open, larger behind surfaces, and large elsewhere:
//
//     +---+---+---+---+      cell (x, y, z) of a node is bit x + 4 y + 16 z of its masks
//     |   |   |#.#|###|      # unseen   . a child: finer cells
//     |   |#.#|###|###|      a cell in none of the masks was seen empty
//     |   |#.#|###|###|
//     +---+---+---+---+
//
// It stands in coverage.bin of the scene folder, little-endian: magic "RVCOVER" 0, version, byte order mark, corner and
// edge of the cube, number of nodes, checksum of the nodes, checksum of the header (XXH3-64); then the nodes. All of it
// is checked before it is believed.

#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

namespace scene {

enum class Observed : std::uint8_t {
    unseen,  ///< in no image's view, or behind what every image saw there
    surface, ///< an image's surface goes through the cell
    empty    ///< an image saw through
};

/// No cell is in two of the masks. Children stand side by side in the order of their bits, behind their parent.
struct CoverageNode {
    std::uint64_t unseen = 0, surface = 0, children = 0;
    std::uint32_t firstChild = 0, reserved = 0;
    friend bool operator==(const CoverageNode&, const CoverageNode&) = default;
};
static_assert(sizeof(CoverageNode) == 32);

inline constexpr int kCoverageBranching = 4;  ///< cells along the edge of a node
inline constexpr int kMaxCoverageLevels = 11; ///< nodes on the way to the smallest cell: 4^11 of them fit into a float

struct Coverage {
    glm::dvec3 cornerInWorld{0.0}; ///< least x, y, z of the whole cube; its axes are the world's
    double edgeMetres = 0;
    std::vector<CoverageNode> nodes; ///< the whole cube first; never empty in a usable coverage
    friend bool operator==(const Coverage&, const Coverage&) = default;
};

/// A cell and what it is. Outside the whole cube nothing was observed.
struct CoverageCell {
    Observed observed = Observed::unseen;
    glm::dvec3 cornerInWorld{0.0};
    double edgeMetres = 0;
};

/// The cell that a point of the world is in; nothing outside of the cube.
std::optional<CoverageCell> cellAt(const Coverage& coverage, const glm::dvec3& pInWorld);

Observed observedAt(const Coverage& coverage, const glm::dvec3& pInWorld);

/// Cubic metres of each kind, by Observed, in a box of the world.
std::array<double, 3> volumesOf(const Coverage& coverage, const glm::dvec3& low, const glm::dvec3& high);

/// Edge of the smallest cell, metres.
double finestCellOf(const Coverage& coverage);

inline int coverageBit(int x, int y, int z) {
    return x + kCoverageBranching * (y + kCoverageBranching * z);
}
inline std::uint64_t coverageMask(int bit) {
    return std::uint64_t{1} << bit;
}
/// Which of the node's children the cell of that bit is.
inline std::uint32_t childRank(std::uint64_t children, int bit) {
    return static_cast<std::uint32_t>(std::popcount(children & (coverageMask(bit) - 1)));
}

inline constexpr const char* kCoverageFile = "coverage.bin"; ///< in the scene folder

/// Throws Failure if the file cannot be written.
void writeCoverage(const Coverage& coverage, const std::filesystem::path& path);

/// Throws Failure with file, place and cause for anything missing, damaged, or of another version.
Coverage readCoverage(const std::filesystem::path& path);

} // namespace scene
