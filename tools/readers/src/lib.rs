//! Reads model, dataset and CSV files
