#pragma once
// Letters drawn with strokes: sharp at any size, and no picture of them to keep.

#include <vector>

#include <glm/vec2.hpp>

namespace render {

/// In a glyph's own units: x to the right from 0 to kGlyphWidth, y down, capitals from 0 to kGlyphHeight (the
/// baseline); what hangs below reaches two units further.
struct GlyphStroke {
    glm::ivec2 a{0}, b{0};
};
inline constexpr int kGlyphWidth = 4, kGlyphHeight = 6;
inline constexpr int kGlyphAdvance = 6; ///< from one glyph's left to the next one's

/// Those of '?' for what is not printable ASCII; none for a space.
const std::vector<GlyphStroke>& strokesOf(char letter);

} // namespace render
