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
    uvec2 masks(uint index) const { return of(made.masks.at(index)); }
    uvec2 link(uint index) const { return of(made.links.at(index)); }

  private:
    static uvec2 of(const CoveragePair& pair) { return {pair[0], pair[1]}; }
};

} // namespace render
