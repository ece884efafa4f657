//! Sans-I/O codecs of the devices Trunnion reads, one file per protocol.
