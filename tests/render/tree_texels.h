#pragma once
// What was observed, as the code shared with shaders reads it on the processor.

#include "render/post/coverage_texels.h"

namespace render {

/// A tree's texels as the shared code asks for them.
struct TreeTexels {
    CoverageTexels made;
    explicit TreeTexels(const scene::Coverage& coverage) : made(coverageTexels(coverage)) {}
    const UnseenGrid& grid() const { return made.grid; }
    uvec4 operator()(uint index) const {
        const CoverageTexel& texel = made.texels.at(index);
        return {texel[0], texel[1], texel[2], texel[3]};
    }
};

} // namespace render
