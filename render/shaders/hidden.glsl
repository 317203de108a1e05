// Which samples of a draw that has passed a look at the z-buffer are hidden by what stood there then
// (shared/occlusion.h). Wants leastAt(eye, block).

const int kWidestHidden = kOccluderSide + 1; // squares no wider touch no more blocks than one in each of their corners

bool hides(uint eye, vec2 pixel, uint disparity)
{
    ivec2 block = ivec2(clamp(pixel, vec2(0.0f), vec2(constants.width, constants.height) - 1.0f)) / kOccluderSide;
    return leastAt(eye, block.y * occludersAlong(constants.width) + block.x) > disparity;
}

/// first: pixel of a square; all of it is hidden.
bool isHidden(uint eye, vec2 first, int size, float seenDisparity)
{
    vec2 last = first + float(size - 1);
    uint disparity = floatBitsToUint(seenDisparity);
    bool above = hides(eye, first, disparity) && hides(eye, vec2(last.x, first.y), disparity);
    return above && hides(eye, vec2(first.x, last.y), disparity) && hides(eye, last, disparity);
}
