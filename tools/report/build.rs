//! Takes plotly.js out of the crate that carries it. As a dependency of this script alone that crate, with thirty
//! others, is compiled without optimisation and is no part of the program.

use std::path::PathBuf;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // The crate hands out plotly.js, then MathJax, which no figure here uses: the first element is the one.
    let both = plotly::Plot::offline_js_sources();
    let start = both.find('>').expect("a script element") + 1;
    let end = both.find("</script>").expect("the end of a script element");
    let folder = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    std::fs::write(folder.join("plotly.min.js"), &both[start..end]).expect("OUT_DIR can be written to");
}
