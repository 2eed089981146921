//! Archives and encapsulated files: any bytes are read or refused.

#![no_main]

use libfuzzer_sys::fuzz_target;
use mdl_frontend::container::Container;

fuzz_target!(|data: &[u8]| {
    for name in ["woods.mdr", "paint.mdle"] {
        if let Ok(container) = Container::read(name, data) {
            for file in container.files() {
                // A file that is damaged is an error.
                let _ = container.file(file);
            }
        }
    }
});
