// Values come from the volume.

// The value at a grid position, if the position can show anything: any may, for all that a volume tells.
fn read_value(grid: vec3f, x: ptr<function, f32>) -> bool {
    *x = sample_x(grid);
    return true;
}
