//! A results file, and the page that is made of it.
#![no_main]
use hollowcast::measure::suite::Results;

libfuzzer_sys::fuzz_target!(|content: &[u8]| {
    let path = hollowcast_fuzz::file("in.jsonl", content);
    if let Some(results) = hollowcast_fuzz::answers(content.len(), || Results::read(&path)) {
        let page = path.with_extension("html");
        hollowcast_fuzz::answers(content.len(), || {
            hollowcast::report::write(std::slice::from_ref(&results), None, &page)
        });
    }
});
