//! Parameters built once into what the tick multiplies with.

use serde::{Deserialize, Serialize};

/// Everything configurable that the tick needs, in its own units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coefficients {}
