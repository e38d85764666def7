//! Tables: records whose rows a solver finds from the model alone, so that several models can be solved for at a time.

use rayon::prelude::*;

use super::simulation::{Direction, Simulation, divide};
use crate::data::Channel;
use crate::model::Model;

/// A record that is a table.
pub(super) trait Table: Send + Sync {
    /// What is solved for.
    type Rows: Send;

    /// As [`Simulation::channels`].
    fn channels(&self) -> &[&Channel];

    /// The rows under `model`.
    fn solve(&self, model: &Model) -> Result<Self::Rows, String>;

    /// Writes what all channels show of `rows`, one after the other.
    fn show(&self, rows: &Self::Rows, out: &mut Vec<f64>);

    /// Keeps `rows` as the start of solutions to come.
    fn keep(&mut self, rows: Self::Rows) {
        let _ = rows;
    }
}

impl<T: Table> Simulation for T {
    fn channels(&self) -> &[&Channel] {
        Table::channels(self)
    }

    fn predict(&mut self, model: &Model, _: &[f64], out: &mut Vec<f64>) -> Result<(), String> {
        let rows = self.solve(model)?;
        out.clear();
        self.show(&rows, out);
        Ok(())
    }

    fn linearise(
        &mut self,
        model: &Model,
        _: &[f64],
        directions: &[Direction],
        predictions: &mut Vec<f64>,
        derivatives: &mut Vec<Vec<f64>>,
    ) -> Result<(), String> {
        let rows = self.solve(model)?;
        predictions.clear();
        self.show(&rows, predictions);
        self.keep(rows);
        self.differences(directions, predictions, derivatives)
    }

    fn differences(
        &mut self,
        directions: &[Direction],
        predictions: &[f64],
        derivatives: &mut Vec<Vec<f64>>,
    ) -> Result<(), String> {
        derivatives.resize_with(directions.len(), Vec::new);
        let table = &*self;
        let predict = |(direction, moved): (&Direction, &mut Vec<f64>)| {
            moved.clear();
            table.show(&table.solve(&direction.model)?, moved);
            Ok(())
        };
        let predicted: Vec<Result<(), String>> =
            directions.par_iter().zip(&mut *derivatives).map(predict).collect();
        divide(directions, predictions, predicted, derivatives)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Channel;

    /// Shows a stiffness, and its square; of one above 3 MN/m there is no solution.
    struct Stiffnesses {
        channels: Vec<&'static Channel>,
        kept: f64,
    }

    impl Table for Stiffnesses {
        type Rows = f64;

        fn channels(&self) -> &[&Channel] {
            &self.channels
        }

        fn solve(&self, model: &Model) -> Result<f64, String> {
            let stiffness = model.get("contact.tangential_stiffness").unwrap() / 1e6;
            if stiffness > 3.0 { Err(format!("{stiffness} is too stiff")) } else { Ok(stiffness) }
        }

        fn show(&self, rows: &f64, out: &mut Vec<f64>) {
            out.extend([*rows, rows * rows]);
        }

        fn keep(&mut self, rows: f64) {
            self.kept = rows;
        }
    }

    fn model(stiffness: f64) -> Model {
        let text = format!(
            "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
             tangential_stiffness = {stiffness}\nfriction_coefficient = 0.5\nnormal_load = 100.0\n"
        );
        Model::parse(&text).unwrap()
    }

    #[test]
    fn models_that_have_no_solution_keep_no_others_from_theirs() {
        let mut table = Stiffnesses { channels: Vec::new(), kept: 0.0 };
        let to = |stiffness: f64| Direction { model: model(stiffness), nuisances: Vec::new(), step: 0.5 };
        let (mut here, mut by) = (Vec::new(), Vec::new());
        let mut linearise = |directions: &[Direction]| {
            let done = table.linearise(&model(2e6), &[], directions, &mut here, &mut by);
            done.map(|()| (here.clone(), by.clone(), table.kept))
        };
        let (predicted, derivatives, kept) = linearise(&[2.5e6, 4e6, 1e6].map(to)).unwrap();
        assert_eq!((predicted, kept), (vec![2.0, 4.0], 2.0));
        assert_eq!((&derivatives[0], &derivatives[2]), (&vec![1.0, 4.5], &vec![-2.0, -6.0]));
        assert!(derivatives[1].len() == 2 && derivatives[1].iter().all(|x| x.is_nan()));
        assert_eq!(linearise(&[5e6, 4e6].map(to)).unwrap_err(), "5 is too stiff");
        assert!(linearise(&[]).unwrap().1.is_empty());
    }
}
