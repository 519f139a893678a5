//! What `hollowcast stability` wrote, and the page that is made of it.
#![no_main]
use hollowcast::report::{self, Atlas};

libfuzzer_sys::fuzz_target!(|content: &[u8]| {
    let path = hollowcast_fuzz::file("in.json", content);
    if let Some(atlas) = hollowcast_fuzz::answers(content.len(), || Atlas::read(&path)) {
        let page = path.with_extension("html");
        hollowcast_fuzz::answers(content.len(), || report::write(&[], Some(&atlas), &page));
    }
});
