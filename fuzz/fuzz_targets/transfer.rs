#![no_main]
use hollowcast::transfer::{Domain, TABLE_SIZES, TransferFunction};
use hollowcast::volume::phantom;

libfuzzer_sys::fuzz_target!(|text: &str| {
    let read = || TransferFunction::from_toml(text);
    let Some(function) = hollowcast_fuzz::answers(text.len(), read) else {
        return;
    };
    let volume = phantom::make("full", [1; 3]).expect("a phantom");
    let domain = Domain::new(&volume, [0.0, 255.0], TABLE_SIZES[0]).expect("a domain");
    for step in [1e-3, 0.5, 1000.0] {
        for entry in function.bake(&domain, step).rgba() {
            assert!(entry.iter().all(|c| (0.0..=1.0).contains(c)), "{entry:?}");
        }
    }
    let again = TransferFunction::from_toml(&function.to_toml());
    assert_eq!(again.expect("what was written is read"), function);
});
