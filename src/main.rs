//! The hollowcast command.

fn main() {}
