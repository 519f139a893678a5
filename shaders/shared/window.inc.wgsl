// Brightness of a value. Twin of mode::Parameters::in_window.
#import shared/mode_settings

// Where a table coordinate lies in the window, 0 to 1; exactly 0 up to a hair above its lower end.
fn in_window(x: f32) -> f32 {
    let v = (x - mode.window_low) * mode.window_scale;
    return select(min(v, 1.0), 0.0, v <= mode.window_dead);
}
