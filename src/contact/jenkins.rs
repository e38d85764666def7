/// placeholder
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jenkins;
