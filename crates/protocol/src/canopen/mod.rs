//! CANopen (CiA 301) as a measuring program needs it: identifiers, network management, SDO both ways, TPDO mapping,
//! and the profiles CiA 404 (probes) and CiA 406 (encoders).
//!
//! What a TPDO means is read from the node with [`startup::NodeStartup`], never taken from a manual.

pub mod cia404;
pub mod cia406;
pub mod network;
pub mod node;
pub mod objects;
pub mod pdo;
pub mod sdo;
pub mod startup;

pub use network::{CobId, Emergency, Message, NmtCommand, NmtState, NodeId};
pub use node::{DecodeError, Identity, NodeDescription, Profile, Reading, Tpdo, Value};
pub use objects::{ObjectKey, RawBits};
pub use pdo::{PdoCommunication, PdoEntry, PdoError, PdoMapping, Transmission};
pub use sdo::{AbortCode, ObjectDictionary, SdoError, SdoProgress, SdoServer, SdoTransfer};
pub use startup::{NodeStartup, StartupError, StartupProgress};
