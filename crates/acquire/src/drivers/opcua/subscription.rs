//! What is subscribed, and how its notifications come here.

use super::connect::{Connection, limited};
use super::nodes::Nodes;
use super::settings::OpcUa;
use crate::link::Link;
use crate::session_end::SessionEnd;
use opcua::client::{MonitoredItemMap, OnSubscriptionNotificationCore};
use opcua::types::{
    AttributeId, DataChangeNotification, DataValue, ExtensionObject, MonitoredItemCreateRequest,
    MonitoringMode, MonitoringParameters, NodeId, NotificationMessage, ReadValueId, StatusChangeNotification,
    StatusCode, TimestampsToReturn,
};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use tokio::sync::mpsc;

/// Values of one item that the server keeps between two publications.
const ITEM_QUEUE: u32 = 20;
/// A subscription without a client's requests is dropped after so many publishing intervals.
const LIFETIME_COUNT: u32 = 3000;
const KEEP_ALIVE_COUNT: u32 = 10;

/// What is subscribed, in this order: axes, then program, state, block, signal where there are such nodes. The client
/// handle of an item is its place, counted from 1.
pub(super) fn items(nodes: &Nodes) -> Vec<(Use, NodeId)> {
    let axes = nodes.axes.iter().enumerate().map(|(k, axis)| (Use::Axis(k), axis.node.clone()));
    let others = [
        (Use::Program, &nodes.program),
        (Use::State, &nodes.state),
        (Use::Block, &nodes.block),
        (Use::Signal, &nodes.signal),
    ];
    let others = others.into_iter().filter_map(|(what, node)| Some((what, node.clone()?)));
    axes.chain(others).collect()
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Use {
    Axis(usize),
    Program,
    State,
    Block,
    Signal,
}

pub(super) async fn subscribe(
    device: &OpcUa,
    connection: &Connection,
    items: &[(Use, NodeId)],
    tap: Tap,
    link: &mut Link,
) -> Result<(), SessionEnd> {
    let session = &connection.session;
    let created =
        session.create_subscription(device.interval, LIFETIME_COUNT, KEEP_ALIVE_COUNT, 0, 0, true, tap);
    let subscription = limited(device, created).await?;
    let interval_ms = device.interval.as_secs_f64() * 1e3;
    let request = |(k, (_, node)): (usize, &(Use, NodeId))| MonitoredItemCreateRequest {
        item_to_monitor: ReadValueId::new(node.clone(), AttributeId::Value),
        monitoring_mode: MonitoringMode::Reporting,
        requested_parameters: MonitoringParameters {
            client_handle: k as u32 + 1,
            sampling_interval: interval_ms,
            filter: ExtensionObject::null(),
            queue_size: ITEM_QUEUE,
            discard_oldest: true,
        },
    };
    let requests = items.iter().enumerate().map(request).collect();
    let created =
        limited(device, session.create_monitored_items(subscription, TimestampsToReturn::Source, requests))
            .await?;
    let mut slowest_ms = interval_ms;
    for ((_, node), item) in items.iter().zip(&created) {
        let status = item.result.status_code;
        if !status.is_good() {
            return Err(SessionEnd::WrongDevice {
                found: format!("a server that does not watch {node} ({status})"),
                expected: "a node that holds a value; correct the node, or allow it to this user".into(),
            });
        }
        slowest_ms = slowest_ms.max(item.result.revised_sampling_interval);
    }
    if slowest_ms > 1.5 * interval_ms {
        link.log(true, format!("the server samples every {slowest_ms} ms, not every {interval_ms} ms"));
    }
    Ok(())
}

pub(super) enum Notification {
    /// Client handles and values of one message, in the server's order.
    Values(Vec<(u32, DataValue)>),
    Ended(StatusCode),
}

/// Sits in the library's task and never waits.
pub(super) struct Tap {
    pub sender: mpsc::Sender<Notification>,
    /// Values that found the queue full.
    pub lost: Arc<AtomicU64>,
}

impl OnSubscriptionNotificationCore for Tap {
    fn on_subscription_notification(&mut self, message: NotificationMessage, _: MonitoredItemMap<'_>) {
        let mut values = Vec::new();
        let mut ended = None;
        for object in message.notification_data.into_iter().flatten() {
            if let Some(change) = object.inner_as::<DataChangeNotification>() {
                let items = change.monitored_items.iter().flatten();
                values.extend(items.map(|item| (item.client_handle, item.value.clone())));
            } else if let Some(change) = object.inner_as::<StatusChangeNotification>() {
                ended = Some(change.status);
            }
        }
        let count = values.len() as u64;
        if count > 0 && self.sender.try_send(Notification::Values(values)).is_err() {
            self.lost.fetch_add(count, Ordering::Relaxed);
        }
        if let Some(status) = ended.filter(StatusCode::is_bad)
            && self.sender.try_send(Notification::Ended(status)).is_err()
        {
            tracing::debug!(%status, "the end of a subscription was not reported; its silence will be");
        }
    }
}
