#pragma once
// What was observed, as the code shared with shaders reads it on the processor.

#include "render/post/coverage_texels.h"

namespace render {

/// A tree's texels as the shared code asks for them.
struct TreeTexels {
    CoverageTexels made;
    explicit TreeTexels(const scene::Coverage& coverage) : made(coverageTexels(coverage)) {}
    const UnseenGrid& grid() const { return made.grid; }
    uint word(uint index) const { return made.words.at(index); }
    uint brick(uint index) const { return made.bricks.at(index); }
    uint base(uint index) const { return made.bases.at(index); }
};

} // namespace render
