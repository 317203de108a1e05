#ifndef RENDER_SHADERS_SHARED_UNSEEN_H
#define RENDER_SHADERS_SHARED_UNSEEN_H
// A pixel's ray through the tree of what was observed (scene/coverage.h): where does it first enter space that no image
// observed? And how such space looks there: dark stripes that stand still in the world, whoever looks.
//
// Positions are in edges of the whole cube, from its corner: [0, 1). Rays are composed in double precision relative to
// the cube, so that its place in the world costs nothing; t counts metres of depth along the eye's z.
//
// The eye itself may stand where nobody looked. What is unseen about it is looked through, but no farther than
// `pocket`: beyond, the ray counts as unseen, and the pattern stands where that stretch ends.
//
// Open space is crossed by a grid of voxels that know how far about them nothing is unseen (Cohen and Sheffer,
// "Proximity clouds", 1994). Where something in a voxel or right beside it is not open, it is a brick of 4 x 4 x 4
// finer ones that know the same, and so on, so that a large site has as fine ones beside its walls as a small one. A
// block of pixels crosses them together, as far as one box of open space after the other holds all of its rays (after
// the beams of Laine and Karras, "Efficient sparse voxel octrees", 2010).
//
// Whoever includes this says with kBrickLevels whether there are any (0), and whether there are bricks in bricks (2): a
// shader for a grid without does not go below, not even where a driver does both sides of a branch.
//
// Before this header: words of the grid through coverageWord(index), of bricks through coverageBrick(index) and
// coverageBase(index), as render/post/coverage_texels.h lays them out; behind it, which grid it is through
// coverageGrid(). No more is read than is asked for: a software driver gathers each word of each invocation by itself.

#include "render/shaders/shared/language.h"
#include "render/shaders/shared/z_key.h"

#ifdef __cplusplus
#include <bit>
#endif

SHARED_BEGIN

struct UnseenConstants {
    vec4 eye;     ///< in the cube; w: pocket, metres of depth
    vec4 base;    ///< direction through the corner of the image at (0, 0), per metre of depth; w: slack
    vec4 perX;    ///< and what a pixel to the right, w: pixels across
    vec4 perY;    ///< or down adds; w: pixels down
    vec4 pattern; ///< stripes' phase per edge of the cube, along x, y, z; w: phase at the eye
    vec4 fade; ///< x: phase per metre; y: a pixel's width at depth 1; z: depth of the sky; w: where it is drawn as if
    vec4 gridFirst; ///< UnseenGrid::first; w: its size
    vec4 gridCount; ///< UnseenGrid::count
};

/// The voxels: a box of cells of one level of the tree about all that was observed. Outside of it, in the cube, all is
/// unseen; nothing is known outside of the cube.
struct UnseenGrid {
    vec3 first; ///< of all voxels that the cube would have room for, the first one along each axis
    float size; ///< voxels along the edge of the cube
    vec3 count; ///< voxels along each edge of the box
};

/// What is known about a place: the largest cube of open space about the voxel that it is in, or that voxel.
struct UnseenCell {
    bool isUnseen;
    vec3 before; ///< from the cube's least corner to the place, voxels
    float edge;  ///< of the cube, voxels
    float voxel; ///< of such a size, in edges of the whole one
};

/// What a ray meets.
struct UnseenHit {
    bool isUnseen;
    float depth; ///< metres along z of where unseen space begins (where it ends, if the eye stands in it); may be
                 ///< infinite
};

#ifdef __cplusplus
static_assert(sizeof(UnseenConstants) == 128); // as much as every device takes
#endif

SHARED_CONSTANT uint kBrick = 0x80000000u; ///< in a voxel's word: of which brick it is, instead of rings
SHARED_CONSTANT uint kWordsPerBrick = 8u;  ///< each of eight of its voxels: three bits for each, and, above them, ...
SHARED_CONSTANT uint kRankBit = 24u;       ///< ... how many of those before are divided
// Of a voxel of a brick. 0: unseen; so many rings of open ones are about it, itself the first; or
SHARED_CONSTANT uint kMostBrickRings = 5u; ///< at most that are told
SHARED_CONSTANT uint kOpenPair = 6u;       ///< one ring, but it is of two by two by two that are all open
SHARED_CONSTANT uint kDividedVoxel = 7u;   ///< it is a brick
SHARED_CONSTANT uint kBeamPixels = 8u;     ///< along the side of a block of pixels
SHARED_CONSTANT int kMostBeamSteps = 64;
/// Voxels: where the boxes are smaller it is no use to go on together.
SHARED_CONSTANT float kLeastBeamStep = 0.05f;
SHARED_CONSTANT int kMostBeamStarts = 12;              ///< so often they begin anew behind what is not open for all
SHARED_CONSTANT float kBeamStart = 0.2f;               ///< so much farther, of the way until there
SHARED_CONSTANT float kLeastBeamStart = 1.0f / 256.0f; ///< of the edge of the cube, at least
SHARED_CONSTANT int kMostUnseenSteps = 2048; ///< through the finest cells of a cube a ray takes fewer in any real scene
SHARED_CONSTANT float kRayInfinity = 1e30f;

#ifdef __cplusplus
constexpr uint kBrickLevels = 2u;
#define COVERAGE_PARAMETER const CoverageTexels &texels,
#define COVERAGE_ARGUMENT texels,
#define COVERAGE_WORD(index) texels.word(index)
#define COVERAGE_BRICK(index) texels.brick(index)
#define COVERAGE_BASE(index) texels.base(index)
#define COVERAGE_GRID texels.grid()
#define COVERAGE_TEMPLATE template <class CoverageTexels>
inline int bitCount(uint word) {
    return std::popcount(word);
}
#else
UnseenGrid coverageGrid();
#define COVERAGE_PARAMETER
#define COVERAGE_ARGUMENT
#define COVERAGE_WORD(index) coverageWord(index)
#define COVERAGE_BRICK(index) coverageBrick(index)
#define COVERAGE_BASE(index) coverageBase(index)
#define COVERAGE_GRID coverageGrid()
#define COVERAGE_TEMPLATE
#endif

/// How many of a word's eight voxels are bricks, which have all three bits set.
SHARED_FUNCTION int bricksIn(uint word) {
    return bitCount(word & (word >> 1) & (word >> 2) & 0x00249249u);
}

/// The voxel of the grid that p, in the cube, is in.
struct UnseenVoxel {
    uint word;
    vec3 within; ///< [0, 1], farther off outside of the grid
};

COVERAGE_TEMPLATE SHARED_FUNCTION UnseenVoxel unseenVoxelAt(COVERAGE_PARAMETER vec3 p) {
    UnseenGrid grid = COVERAGE_GRID;
    vec3 scaled = p * grid.size;
    vec3 at = clamp(floor(scaled), grid.first, grid.first + grid.count - vec3(1.0f));
    // Exactly: there are no more voxels than single precision counts.
    vec3 inGrid = at - grid.first;
    float index = (inGrid.z * grid.count.y + inGrid.y) * grid.count.x + inGrid.x;
    UnseenVoxel voxel;
    voxel.word = COVERAGE_WORD(uint(int(index)));
    voxel.within = scaled - at;
    return voxel;
}

/// A voxel of the grid that is no brick.
SHARED_FUNCTION UnseenCell cellOfVoxel(UnseenVoxel voxel, float size) {
    float beside = max(float(int(voxel.word & ~kBrick)), 1.0f) - 1.0f;
    UnseenCell cell;
    cell.isUnseen = voxel.word == 0u;
    cell.before = voxel.within + vec3(beside);
    cell.edge = 1.0f + 2.0f * beside;
    cell.voxel = 1.0f / size;
    return cell;
}

/// The voxel of a brick that a place in it, [0, 4], is in.
SHARED_FUNCTION vec3 voxelOfBrick(vec3 within) {
    return clamp(floor(within), vec3(0.0f), vec3(3.0f));
}
SHARED_FUNCTION uint bitOfVoxel(vec3 at) {
    return uint(int(at.x + 4.0f * at.y + 16.0f * at.z));
}

/// A voxel of a brick that is none, `at` in it.
SHARED_FUNCTION UnseenCell cellOfBrick(uint known, vec3 at, vec3 within, float voxel) {
    bool isPair = known == kOpenPair;
    float beside = max(float(int(known)), 1.0f) - 1.0f;
    UnseenCell cell;
    cell.isUnseen = known == 0u;
    cell.before = within + (isPair ? at - 2.0f * floor(at * 0.5f) : vec3(beside));
    cell.edge = isPair ? 2.0f : 1.0f + 2.0f * beside;
    cell.voxel = voxel;
    return cell;
}

/// Bricks of the grid alone are looked at, p in the cube: a divided voxel of one counts as unseen.
COVERAGE_TEMPLATE SHARED_FUNCTION UnseenCell roughCellAt(COVERAGE_PARAMETER vec3 p) {
    UnseenGrid grid = COVERAGE_GRID;
    UnseenVoxel top = unseenVoxelAt(COVERAGE_ARGUMENT p);
    if (kBrickLevels == 0u || (top.word & kBrick) == 0u) return cellOfVoxel(top, grid.size);
    vec3 within = top.within * 4.0f;
    vec3 at = voxelOfBrick(within);
    uint bit = bitOfVoxel(at);
    uint known = (COVERAGE_BRICK(kWordsPerBrick * (top.word & ~kBrick) + (bit >> 3)) >> (3u * (bit & 7u))) & 7u;
    return cellOfBrick(known == kDividedVoxel ? 0u : known, at, within - at, 0.25f / grid.size);
}

/// p in the cube.
COVERAGE_TEMPLATE SHARED_FUNCTION UnseenCell unseenCellAt(COVERAGE_PARAMETER vec3 p) {
    if (kBrickLevels < 2u) return roughCellAt(COVERAGE_ARGUMENT p);
    UnseenGrid grid = COVERAGE_GRID;
    UnseenVoxel top = unseenVoxelAt(COVERAGE_ARGUMENT p);
    if ((top.word & kBrick) == 0u) return cellOfVoxel(top, grid.size);
    uint brick = top.word & ~kBrick;
    vec3 within = top.within;
    float voxel = 1.0f / grid.size;
    while (true) {
        within = within * 4.0f;
        voxel = voxel * 0.25f;
        vec3 at = voxelOfBrick(within);
        within = within - at;
        uint bit = bitOfVoxel(at), shift = 3u * (bit & 7u);
        uint eight = COVERAGE_BRICK(kWordsPerBrick * brick + (bit >> 3));
        uint known = (eight >> shift) & 7u;
        if (known != kDividedVoxel) return cellOfBrick(known, at, within, voxel);
        brick = COVERAGE_BASE(brick) + (eight >> kRankBit) + uint(bricksIn(eight & ((1u << shift) - 1u)));
    }
    return cellOfVoxel(top, grid.size);
}

/// Metres of depth to where a ray leaves the cell; per: 1 / direction, ahead: 1 where that is not negative, else 0.
SHARED_FUNCTION float leaveCell(UnseenCell cell, vec3 per, vec3 ahead) {
    vec3 t = (ahead * cell.edge - cell.before) * per;
    return max(min(min(t.x, t.y), t.z), 0.0f) * cell.voxel;
}

/// A direction's part that is never zero: what is parallel to a face never gets there.
SHARED_FUNCTION float safeInverse(float part) {
    return 1.0f / (abs(part) < 1e-12f ? (part < 0.0f ? -1e-12f : 1e-12f) : part);
}

/// The longest stretch of open space that rays from the eye pass together, all of those between four corners: base,
/// base + across, base + down, and with both. Metres of depth, from where to where; both 0 if there is none. end: none
/// of them need be known farther. What is closed is passed by steps, since an eye often stands in it: in a narrow gap
/// of what was observed, or in a pocket.
COVERAGE_TEMPLATE SHARED_FUNCTION vec2 openStretch(COVERAGE_PARAMETER vec3 eye, vec3 base, vec3 across, vec3 down,
                                                   float end) {
    UnseenGrid grid = COVERAGE_GRID;
    float size = grid.size * 4.0f; // voxels of bricks
    vec3 middle = base + 0.5f * (across + down);
    vec3 beside = 0.5f * (abs(across) + abs(down));
    // All are between two rays, seen along each axis by itself.
    vec3 most = middle + beside, least = middle - beside;
    vec3 perMost = vec3(safeInverse(most.x), safeInverse(most.y), safeInverse(most.z));
    vec3 perLeast = vec3(safeInverse(least.x), safeInverse(least.y), safeInverse(least.z));
    // What does not move towards a face never gets there.
    vec3 neverHigh = vec3(most.x > 0.0f ? 0.0f : kRayInfinity, most.y > 0.0f ? 0.0f : kRayInfinity,
                          most.z > 0.0f ? 0.0f : kRayInfinity);
    vec3 neverLow = vec3(least.x < 0.0f ? 0.0f : kRayInfinity, least.y < 0.0f ? 0.0f : kRayInfinity,
                         least.z < 0.0f ? 0.0f : kRayInfinity);
    float perVoxel = 1.0f / (size * max(max(abs(middle.x), abs(middle.y)), abs(middle.z)));
    float perStart = perVoxel * size * kLeastBeamStart;
    vec2 best = vec2(0.0f, 0.0f);
    float t = 0.0f, from = 0.0f;
    int closed = 0;
    for (int i = 0; i < kMostBeamSteps && closed < kMostBeamStarts && t < end; ++i) {
        vec3 p = eye + t * middle;
        UnseenCell cell = roughCellAt(COVERAGE_ARGUMENT p); // where bricks are in bricks, beams are too wide
        vec3 low = p - cell.before * cell.voxel;
        vec3 high = low + vec3(cell.edge * cell.voxel);
        vec3 inside = min(high - (eye + t * most), (eye + t * least) - low);
        vec3 leave = min((high - eye) * perMost + neverHigh, (low - eye) * perLeast + neverLow);
        float next = min(min(leave.x, leave.y), leave.z);
        bool isOpen =
            !cell.isUnseen && min(min(inside.x, inside.y), inside.z) >= 0.0f && next > t + kLeastBeamStep * perVoxel;
        if (isOpen) {
            t = next;
            if (t - from > best.y - best.x) best = vec2(from, t);
        } else {
            t = t + max(perStart, kBeamStart * t);
            from = t;
            closed = closed + 1;
        }
    }
    return best;
}

SHARED_FUNCTION bool isInCube(vec3 p) {
    return min(min(p.x, p.y), p.z) >= 0.0f && max(max(p.x, p.y), p.z) < 1.0f;
}

SHARED_FUNCTION vec3 inCubeAt(vec3 eye, vec3 direction, float t) {
    PRECISE vec3 p = eye + t * direction;
    return clamp(p, vec3(0.0f), vec3(0.9999999f));
}

/// eye, direction: in edges of the cube; end: metres of depth to where something is drawn, infinite if nothing is;
/// open: a stretch of metres of depth that is known to be open space.
COVERAGE_TEMPLATE SHARED_FUNCTION UnseenHit walkToUnseen(COVERAGE_PARAMETER vec3 eye, vec3 direction, float pocket,
                                                         float end, vec2 open) {
    UnseenHit hit;
    hit.isUnseen = false;
    hit.depth = kRayInfinity;
    vec3 per = vec3(safeInverse(direction.x), safeInverse(direction.y), safeInverse(direction.z));
    vec3 ahead = vec3(per.x >= 0.0f ? 1.0f : 0.0f, per.y >= 0.0f ? 1.0f : 0.0f, per.z >= 0.0f ? 1.0f : 0.0f);
    // Where the grid begins and ends; outside nothing was observed.
    UnseenGrid grid = COVERAGE_GRID;
    vec3 toLow = (grid.first / grid.size - eye) * per;
    vec3 toHigh = ((grid.first + grid.count) / grid.size - eye) * per;
    vec3 in_ = min(toLow, toHigh);
    vec3 out_ = max(toLow, toHigh);
    float enter = max(max(max(in_.x, in_.y), in_.z), 0.0f);
    float leave = min(min(out_.x, out_.y), out_.z);
    bool isMissed = !(enter < leave);
    if (pocket <= 0.0f && (isMissed || enter > 0.0f) && isInCube(eye)) {
        // Beside the grid, in the cube: unseen where the eye stands.
        hit.isUnseen = end > 0.0f;
        hit.depth = 0.0f;
        return hit;
    }

    bool isEyeOpen = open.x <= 0.0f && open.y > 0.0f;
    bool isInPocket = !isEyeOpen && (isMissed || enter > 0.0f || pocket > 0.0f);
    float t = enter;
    float last = min(end, leave);
    // A nudge past a cell's face: what floats can still tell apart there.
    float perStep = max(max(abs(direction.x), abs(direction.y)), abs(direction.z));
    float grain = 2e-7f / perStep;
    bool hasBegun = !isInPocket;
    if (!isMissed) {
        for (int i = 0; i < kMostUnseenSteps && t < last; ++i) {
            t = hasBegun && t >= open.x ? max(t, open.y) : t;
            if (t >= last) break;
            UnseenCell cell = unseenCellAt(COVERAGE_ARGUMENT inCubeAt(eye, direction, t));
            if (cell.isUnseen && hasBegun) {
                hit.isUnseen = true;
                hit.depth = t;
                return hit;
            }
            if (!cell.isUnseen && !hasBegun) {
                if (t > pocket) break;
                hasBegun = true;
            }
            t = t + leaveCell(cell, per, ahead) + grain + t * 1e-6f;
        }
    }
    if (!hasBegun) {
        // Unseen from the eye on, to here at least.
        float reached = isMissed || t >= leave ? end : min(t, end);
        hit.isUnseen = reached > pocket;
        hit.depth = reached;
    }
    return hit;
}

/// The stripes' shade at a phase, 0 to 1: two tones, softened over `width` of a period on either side.
SHARED_FUNCTION float stripeAt(float phase, float width) {
    float wave = abs(phase - floor(phase) - 0.5f) * 2.0f; // 0 in the middle of a dark stripe, 1 of a light one
    float soft = clamp(width * 2.0f, 0.02f, 2.0f);
    float stripe = clamp((wave - 0.5f) / soft + 0.5f, 0.0f, 1.0f);
    return mix(stripe, 0.5f, clamp(width * 2.0f - 0.5f, 0.0f, 1.0f));
}

/// r | g << 8 | b << 16: dark, bluish, unlike any light on a surface.
SHARED_FUNCTION uint stripeColour(float shade) {
    vec3 dark = vec3(26.0f, 28.0f, 38.0f);
    vec3 light = vec3(58.0f, 62.0f, 80.0f);
    vec3 colour = mix(dark, light, vec3(shade)) + vec3(0.5f);
    return uint(int(colour.x)) | (uint(int(colour.y)) << 8) | (uint(int(colour.z)) << 16);
}

/// Direction of the pixel's ray, per metre of depth. x, y: of the pixel's centre.
SHARED_FUNCTION vec3 rayOf(UnseenConstants c, float x, float y) {
    PRECISE vec3 direction = vec3(c.base.x, c.base.y, c.base.z) + x * vec3(c.perX.x, c.perX.y, c.perX.z) +
                             y * vec3(c.perY.x, c.perY.y, c.perY.z);
    return direction;
}

/// How far a pixel's ray is asked about: to just before what is drawn there. pixelClass and depth as resolve wrote
/// them.
SHARED_FUNCTION float unseenEnd(UnseenConstants c, uint pixelClass, float depth) {
    bool isDrawn = pixelClass != kClassBackground && depth < kRayInfinity;
    return isDrawn ? depth * (1.0f - c.base.w) : kRayInfinity;
}

/// How unseen space looks at that depth along a ray. Infinitely far, the pattern stands on the sky.
SHARED_FUNCTION uint unseenColour(UnseenConstants c, vec3 direction, float depth) {
    vec3 pattern = vec3(c.pattern.x, c.pattern.y, c.pattern.z);
    bool isFar = depth > c.fade.z;
    float t = isFar ? c.fade.w : depth;
    vec3 offset = direction * t;
    float phase = pattern.x * offset.x + pattern.y * offset.y + pattern.z * offset.z + (isFar ? 0.0f : c.pattern.w);
    return stripeColour(stripeAt(phase, c.fade.x * c.fade.y * t));
}

SHARED_END

#endif
