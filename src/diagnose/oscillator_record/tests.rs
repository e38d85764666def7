//! Items to verify: see the names.
