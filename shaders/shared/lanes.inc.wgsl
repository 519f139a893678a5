// Which pixel of its tile an invocation draws.

// Invocations that run in step follow each other by index: eight of them take a patch of 4x2 pixels, thirty-two one of 8x4,
// whose rays stay together better than those of a row.
fn pixel_of(tile: Tile, index: u32) -> vec2u {
    let x = (index & 3u) | (index >> 1u & 4u);
    let y = (index >> 2u & 1u) | (index >> 3u & 6u);
    return vec2u(tile.at & 0xffffu, tile.at >> 16u) * 8u + vec2u(x, y);
}
