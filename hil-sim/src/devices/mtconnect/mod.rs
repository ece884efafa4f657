//! MTConnect agent.
