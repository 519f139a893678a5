// Lists of the runs of every tile, in depth along the unnormalised direction, ascending, slot by slot; a run that ends below 0
// ends a list that is not full.
#import shared/view
#import shared/march_settings

fn tiles_in_row() -> u32 {
    return (view.size.x + 7u) / 8u;
}

// Lists of the picture.
fn list_count() -> u32 {
    return tiles_in_row() * ((view.size.y + 7u) / 8u);
}

// Which of them is a tile's.
fn list_of(tile: Tile) -> u32 {
    return (tile.at >> 16u) * tiles_in_row() + (tile.at & 0xffffu);
}
