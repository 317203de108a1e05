// Which of a draw's items stand in the rows that are drawn (shared/occlusion.h): they come row by row. Wants rowOf(draw,
// item).

uint firstOfRow(TileDraw draw, uint row)
{
    uint low = 0u, high = draw.span.z;
    while (low < high) {
        uint middle = (low + high) / 2u;
        if (rowOf(draw, middle) < row)
            low = middle + 1u;
        else
            high = middle;
    }
    return low;
}

/// First and end.
uvec2 itemsIn(TileDraw draw, uint rows)
{
    uvec2 items = uvec2(0u, draw.span.z);
    uint first = rows & 0xffu, end = rows >> 8;
    if (first > 0u) items.x = firstOfRow(draw, first);
    if (end < uint(heightOf(draw))) items.y = firstOfRow(draw, end);
    return items;
}
