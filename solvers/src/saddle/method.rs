//! The list of everything that solves a saddle point: the settings tree behind `solve` and `spectrum`.

use super::inner::Ready;
use super::{
    AugmentationChoice, AugmentedLagrangian, BlockDiagonal, BlockTriangular, Direct,
    EliminatedInverse, Elimination, Form, InnerChoice, Mcp, PressureSchur, RELAXATION, Racp,
    SaddleBlocks, Simple, ThreeFields,
};
use crate::registry::{NameTaken, Named, Registered, Registry};
use crate::written::{self, Written};
use crate::{Prepare, SetupError};
use fracas_operators::Preconditioner;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

/// What every method of the list knows about itself.
pub trait SaddleSettings {
    /// Plain name.
    fn name(&self) -> &'static str;

    /// Everything that depends on the blocks but not on a right-hand side; the blocks are checked and without flow,
    /// unless the method takes it.
    ///
    /// # Errors
    /// Those of the parts, each with block and row.
    fn ready(&self, blocks: &SaddleBlocks) -> Result<Ready, SetupError>;

    /// The choice of C, where one is made.
    fn augmentation(&self) -> Option<AugmentationChoice> {
        None
    }

    /// Takes this C; false where the method has none.
    fn set_augmentation(&mut self, _c: AugmentationChoice) -> bool {
        false
    }

    /// True where the method takes flow blocks.
    fn takes_flow(&self) -> bool {
        false
    }

    /// True where the method itself sees to rows that determine their own traction ([`Elimination`]).
    fn takes_local_rows(&self) -> bool {
        false
    }

    /// The third field, where the method preconditions it by parts.
    fn flow_mut(&mut self) -> Option<&mut ThreeFields> {
        None
    }

    /// The solver of the displacement block, where there is one.
    fn inner_mut(&mut self) -> Option<&mut InnerChoice> {
        None
    }
}

/// Which preconditioner of `𝒜 = [A B1; B2 −H]`. Written as `"racp"`, `"racp:published"` (also `"racp:0"`: C = local_h, H not relaxed), `"mcp"`, `"mcp:0"`
/// (factor of γ), `"direct:faer"` or `{ mcp = { inner = "amg" } }`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self", rename_all = "snake_case")]
pub enum SaddleMethod {
    /// Reverse augmented constraint preconditioner.
    Racp(Racp),
    /// Mixed constraint preconditioner on A + γBBᵀ.
    Mcp(Mcp),
    /// Augmented Lagrangian.
    AugmentedLagrangian(AugmentedLagrangian),
    /// diag(Â, Ŝ).
    BlockDiagonal(BlockDiagonal),
    /// [Â B1; 0 −Ŝ].
    BlockTriangular(BlockTriangular),
    /// SIMPLE, or the full block factorization with its Schur complement.
    Simple(Simple),
    /// Sparse LU of the whole matrix.
    Direct(Direct),
    /// Somebody else's.
    #[serde(skip)]
    Other(Registered<dyn CustomMethod>),
}

/// A preconditioner of the saddle point that somebody else brings; [`register`](SaddleMethod::register) makes its name known.
pub trait CustomMethod: Named {
    /// M⁻¹ for these blocks, which are checked.
    ///
    /// # Errors
    /// [`SetupError`] with block and row.
    fn prepare(&self, blocks: &SaddleBlocks) -> Result<Box<dyn Preconditioner<f64>>, SetupError>;

    /// True where it takes flow blocks.
    fn takes_flow(&self) -> bool;

    /// True where it sees to rows that determine their own traction itself; else they are eliminated first ([`Elimination`]).
    fn takes_local_rows(&self) -> bool;
}

static METHODS: Registry<dyn CustomMethod> = Registry::new("method");

impl SaddleSettings for Registered<dyn CustomMethod> {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn ready(&self, blocks: &SaddleBlocks) -> Result<Ready, SetupError> {
        Ok(self.0.prepare(blocks)?.into())
    }

    fn takes_flow(&self) -> bool {
        self.0.takes_flow()
    }

    fn takes_local_rows(&self) -> bool {
        self.0.takes_local_rows()
    }
}

impl Default for SaddleMethod {
    fn default() -> Self {
        Self::Racp(Racp::default())
    }
}

impl SaddleMethod {
    /// Every method with its default settings.
    pub fn all() -> [Self; 7] {
        [
            Self::default(),
            Self::Mcp(Mcp::default()),
            Self::AugmentedLagrangian(AugmentedLagrangian::default()),
            Self::BlockDiagonal(BlockDiagonal::default()),
            Self::BlockTriangular(BlockTriangular::default()),
            Self::Simple(Simple::default()),
            Self::Direct(Direct::default()),
        ]
    }

    /// Makes a method known by its name.
    ///
    /// # Errors
    /// [`NameTaken`] where another method has it.
    pub fn register(method: &'static dyn CustomMethod) -> Result<Self, NameTaken> {
        METHODS.register::<Self>(method).map(Self::Other)
    }

    /// The settings of the chosen method.
    pub fn settings(&self) -> &dyn SaddleSettings {
        match self {
            Self::Racp(settings) => settings,
            Self::Mcp(settings) => settings,
            Self::AugmentedLagrangian(settings) => settings,
            Self::BlockDiagonal(settings) => settings,
            Self::BlockTriangular(settings) => settings,
            Self::Simple(settings) => settings,
            Self::Direct(settings) => settings,
            Self::Other(settings) => settings,
        }
    }

    fn settings_mut(&mut self) -> &mut dyn SaddleSettings {
        match self {
            Self::Racp(settings) => settings,
            Self::Mcp(settings) => settings,
            Self::AugmentedLagrangian(settings) => settings,
            Self::BlockDiagonal(settings) => settings,
            Self::BlockTriangular(settings) => settings,
            Self::Simple(settings) => settings,
            Self::Direct(settings) => settings,
            Self::Other(settings) => settings,
        }
    }

    /// Plain name.
    pub fn name(&self) -> &'static str {
        self.settings().name()
    }

    /// Everything that depends on the blocks but not on a right-hand side. Slipping and open rows are eliminated alike for
    /// every method, so that all of them meet the same definite system.
    ///
    /// # Errors
    /// Those of the parts, each with block and row; [`SetupError::NotApplicable`] for flow blocks in a method that solves
    /// for u and t.
    pub fn ready(&self, blocks: &SaddleBlocks) -> Result<Ready, SetupError> {
        blocks.check()?;
        let settings = self.settings();
        if blocks.flow.is_some() && !settings.takes_flow() {
            return Err(SetupError::NotApplicable {
                method: self.name(),
                reason: "the system has flow blocks (Q1, Q2, T), this method solves for u and t; take method = \"racp\" or \"direct\"".into(),
            });
        }
        if settings.takes_local_rows() {
            return settings.ready(blocks);
        }
        let Some(elimination) = Elimination::new(blocks) else {
            return settings.ready(blocks);
        };
        match settings.ready(&elimination.with_identity()) {
            Ok(kept) => Ok(kept.inside(|inverse| EliminatedInverse::new(elimination, inverse))),
            // A' may be indefinite where A is not
            Err(reduced) => settings.ready(blocks).map_err(|_| reduced),
        }
    }

    /// The settings of RACP where A is never assembled.
    pub fn matrix_free(&self) -> Option<Racp> {
        match self {
            Self::Racp(racp) => Some(*racp).filter(Racp::is_matrix_free),
            _ => None,
        }
    }

    /// The choice of C, in methods that make one.
    pub fn augmentation(&self) -> Option<AugmentationChoice> {
        self.settings().augmentation()
    }

    /// The inner solver, in methods that have one.
    pub fn inner(mut self) -> Option<InnerChoice> {
        self.settings_mut().inner_mut().copied()
    }

    /// The same method with this C and this inner solver, where they are given.
    ///
    /// # Errors
    /// [`NoSuchPart`] when the method does not have what is given.
    pub fn with_parts(
        mut self,
        augmentation: Option<AugmentationChoice>,
        inner: Option<InnerChoice>,
    ) -> Result<Self, NoSuchPart> {
        if let Some(given) = augmentation
            && !self.settings_mut().set_augmentation(given)
        {
            return Err(self.without("augmentation C", |mut m| {
                m.settings_mut().set_augmentation(given)
            }));
        }
        if let Some(given) = inner {
            let no_inner = self.without("inner solver", |m| m.inner().is_some());
            *self.settings_mut().inner_mut().ok_or(no_inner)? = given;
        }
        Ok(self)
    }

    /// The same method with this S_p and this form of the block factorization, where they are given.
    ///
    /// # Errors
    /// [`NoSuchPart`] when the method does not have what is given.
    pub fn with_flow(
        mut self,
        schur: Option<PressureSchur>,
        form: Option<Form>,
    ) -> Result<Self, NoSuchPart> {
        if schur.is_none() && form.is_none() {
            return Ok(self);
        }
        let has_flow = |mut m: Self| m.settings_mut().flow_mut().is_some();
        let no_flow = self.without("Schur complement of the pressures", has_flow);
        let flow = self.settings_mut().flow_mut().ok_or(no_flow)?;
        flow.schur = schur.unwrap_or(flow.schur);
        flow.form = form.unwrap_or(flow.form);
        Ok(self)
    }

    fn without(&self, part: &'static str, has: impl Fn(Self) -> bool) -> NoSuchPart {
        NoSuchPart {
            method: self.name(),
            part,
            others: Self::all()
                .into_iter()
                .filter(|m| has(*m))
                .map(|m| m.name())
                .collect(),
        }
    }
}

impl Prepare<SaddleBlocks, f64> for SaddleMethod {
    fn prepare(&self, blocks: &SaddleBlocks) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        Ok(self.ready(blocks)?.inverse)
    }
}

/// A choice that means nothing to a method.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("method {method} has no {part}; methods with one: {}", others.join(", "))]
pub struct NoSuchPart {
    /// The method.
    pub method: &'static str,
    /// What it does not have.
    pub part: &'static str,
    /// Methods that have it.
    pub others: Vec<&'static str>,
}

/// A name that is none of [`SaddleMethod`]'s.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown method {found:?}: expected {}", names())]
pub struct UnknownSaddleMethod {
    /// What was given.
    pub found: String,
}

/// All names, as a list for people.
fn names() -> String {
    let plain: Vec<&str> = SaddleMethod::all().iter().map(SaddleMethod::name).collect();
    format!(
        "{}, racp:published, racp:RELAXATION (0 to 1; 0: as published), mcp:FACTOR or direct:BACKEND{}",
        plain.join(", "),
        METHODS.names()
    )
}

impl fmt::Display for SaddleMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Racp(Racp { relaxation, .. }) if *relaxation == 0.0 => {
                f.write_str("racp:published")
            }
            Self::Racp(Racp { relaxation, .. }) if *relaxation != RELAXATION => {
                write!(f, "racp:{relaxation}")
            }
            Self::Mcp(Mcp { gamma_factor, .. }) if *gamma_factor != 1.0 => {
                write!(f, "mcp:{gamma_factor}")
            }
            Self::Direct(Direct { backend }) if *backend != Default::default() => {
                write!(f, "direct:{backend}")
            }
            _ => f.write_str(self.name()),
        }
    }
}

impl FromStr for SaddleMethod {
    type Err = UnknownSaddleMethod;

    fn from_str(text: &str) -> Result<Self, UnknownSaddleMethod> {
        let unknown = || UnknownSaddleMethod { found: text.into() };
        let (name, detail) = match text.split_once(':') {
            Some((name, detail)) => (name, Some(detail)),
            None => (text, None),
        };
        let own = Self::all().into_iter().find(|m| m.name() == name);
        let found = own.or_else(|| METHODS.find(name).map(Self::Other));
        match (found.ok_or_else(unknown)?, detail) {
            (method, None) => Ok(method),
            (Self::Racp(racp), Some("published")) => Ok(Self::Racp(Racp::published(racp.inner))),
            (Self::Racp(racp), Some(detail)) => match detail.parse::<f64>() {
                Ok(0.0) => Ok(Self::Racp(Racp::published(racp.inner))),
                Ok(relaxation) if (0.0..=1.0).contains(&relaxation) => {
                    Ok(Self::Racp(Racp { relaxation, ..racp }))
                }
                _ => Err(unknown()),
            },
            (Self::Mcp(mcp), Some(detail)) => match detail.parse::<f64>() {
                Ok(factor) if factor >= 0.0 && factor.is_finite() => Ok(Self::Mcp(Mcp {
                    gamma_factor: factor,
                    ..mcp
                })),
                _ => Err(unknown()),
            },
            (Self::Direct(_), Some(detail)) => match detail.parse() {
                Ok(backend) => Ok(Self::Direct(Direct { backend })),
                Err(_) => Err(unknown()),
            },
            _ => Err(unknown()),
        }
    }
}

impl Serialize for SaddleMethod {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Other(method) => method.serialize(serializer),
            own => Self::serialize(own, serializer),
        }
    }
}

impl<'de> Deserialize<'de> for SaddleMethod {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        written::read(deserializer)
    }
}

impl Written for SaddleMethod {
    const EXPECTED: &'static str = "a method such as \"racp\" or { racp = { inner = \"amg\" } }";

    fn from_table<'de, D: Deserializer<'de>>(table: D) -> Result<Self, D::Error> {
        Self::deserialize(table)
    }
}

impl JsonSchema for SaddleMethod {
    fn schema_name() -> Cow<'static, str> {
        "SaddleMethod".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let tables: serde_json::Map<String, serde_json::Value> = Self::all()
            .iter()
            .filter_map(|method| {
                let settings = match method {
                    Self::Racp(_) => generator.subschema_for::<Racp>(),
                    Self::Mcp(_) => generator.subschema_for::<Mcp>(),
                    Self::AugmentedLagrangian(_) => {
                        generator.subschema_for::<AugmentedLagrangian>()
                    }
                    Self::BlockDiagonal(_) => generator.subschema_for::<BlockDiagonal>(),
                    Self::BlockTriangular(_) => generator.subschema_for::<BlockTriangular>(),
                    Self::Simple(_) => generator.subschema_for::<Simple>(),
                    Self::Direct(_) => generator.subschema_for::<Direct>(),
                    Self::Other(_) => return None,
                };
                Some((method.name().to_owned(), settings.to_value()))
            })
            .collect();
        let names: Vec<&str> = Self::all().iter().map(Self::name).collect();
        json_schema!({
            "description": "A method: \"racp\", \"mcp:0\", \"direct:faer\" or { racp = { inner = \"amg\" } }.",
            "anyOf": [
                { "type": "string", "pattern": format!("^({})$|^racp:|^mcp:|^direct:", names.join("|")) },
                {
                    "type": "object", "properties": tables, "additionalProperties": false,
                    "minProperties": 1, "maxProperties": 1
                }
            ]
        })
    }
}
