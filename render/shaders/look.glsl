// Which rows of a tile may still change the picture of an eye (shared/occlusion.h). Wants occluderTexel(eye, block) and
// drawTexel(eye, at): software drivers read texels faster than buffers.

Occluder occluderAt(uint eye, int block)
{
    uvec4 texel = occluderTexel(eye, block);
    return Occluder(texel.x, texel.y, texel.z, texel.w);
}

const int kDrawTexels = 7; // tile_draw.h asserts that they are 112 bytes

TileDraw drawAt(uint eye, uint number)
{
    int first = kDrawTexels * int(number);
    TileDraw draw;
    draw.base = uintBitsToFloat(drawTexel(eye, first));
    draw.perX = uintBitsToFloat(drawTexel(eye, first + 1));
    draw.perY = uintBitsToFloat(drawTexel(eye, first + 2));
    draw.perQ = uintBitsToFloat(drawTexel(eye, first + 3));
    draw.span = drawTexel(eye, first + 4);
    draw.source = drawTexel(eye, first + 5);
    draw.detail = uintBitsToFloat(drawTexel(eye, first + 6));
    return draw;
}

uint rowsSeen(uint eye, TileDraw draw, uint kindOfRun, int width, int height)
{
    bool isSplats = (kindOfRun & kSplatRun) != 0u;
    TileReach reach = reachOf(draw, isSplats, width, height);
    if (reach.nearest < 0.0f) return kAllRows;
    if (reach.last.x < reach.first.x || reach.last.y < reach.first.y) return kNoRows;
    ivec2 first = reach.first / kOccluderSide, last = reach.last / kOccluderSide, size = last - first + 1;
    if (size.x * size.y > kMostOccluders) return kAllRows;
    int across = occludersAlong(width);
    Opening opening = noOpening();
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x)
            opening = withBlock(opening, reach, ivec2(x, y), occluderAt(eye, y * across + x));
    bool isHidden = opening.last.x < opening.first.x;
    uint rows = rowsIn(opening, draw, isSplats, !isHidden && (kindOfRun & kWholeRun) == 0u);
    return isHidden ? kNoRows : rows;
}
