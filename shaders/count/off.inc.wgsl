// No counters: what is timed.

fn count_begin(at: u32) {}

fn count_skip() {}

fn count_probe() {}

fn count_sample(contributes: bool, k: u32, ray: Ray) {}

fn count_end(at: u32) {}
