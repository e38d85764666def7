//! Texts that many variables have in common.

use std::collections::BTreeSet;
use std::sync::Arc;

/// Most texts that are known: where there are more, they are hardly ever equal, and looking them up would cost memory itself.
const MOST: usize = 1000;

/// Equal texts, each kept once: a million variables have a handful of units and start values.
#[derive(Debug, Default)]
pub(crate) struct Words(BTreeSet<Arc<str>>);

impl Words {
    /// `text`, together with all that ask for the same one.
    pub fn shared(&mut self, text: &str) -> Arc<str> {
        if let Some(known) = self.0.get(text) {
            return Arc::clone(known);
        }
        let new: Arc<str> = Arc::from(text);
        if self.0.len() < MOST {
            self.0.insert(Arc::clone(&new));
        }
        new
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_texts_are_one_as_long_as_there_are_few() {
        let mut words = Words::default();
        let first = words.shared("N");
        assert!(Arc::ptr_eq(&first, &words.shared("N")));
        for number in 0..2 * MOST {
            words.shared(&number.to_string());
        }
        assert!(Arc::ptr_eq(&first, &words.shared("N")));
        assert_eq!((words.0.len(), &*words.shared("1999")), (MOST, "1999"));
    }
}
