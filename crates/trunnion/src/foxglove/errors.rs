//! Errors as arrows: how far the table side is shifted against the tool, at the place where it was measured.
//!
//! tip = commanded + M·d    d the measured shift, or what the model leaves of it; M the magnification

use super::scene::{metadata, shown_s};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use trunnion_core::convert::mm_from_um;
use trunnion_record::RecordError;
use trunnion_record::foxglove::messages::{ArrowPrimitive, Color, SceneEntity, SceneUpdate};
use trunnion_record::foxglove::{Channel, FoxgloveWriter, metres, pose};
use trunnion_results::{ResidualPoint, Residuals};

pub const MEASURED: Channel = Channel { topic: "/errors/measured", schema: "foxglove.SceneUpdate" };
pub const RESIDUAL: Channel = Channel { topic: "/errors/residual", schema: "foxglove.SceneUpdate" };

const BLUE: Color = Color { r: 0.12, g: 0.42, b: 0.78, a: 1.0 };
const ORANGE: Color = Color { r: 0.9, g: 0.45, b: 0.05, a: 1.0 };
const GREY: Color = Color { r: 0.6, g: 0.6, b: 0.6, a: 0.6 };
/// Thickness of a shaft, and length of a head as a share of the arrow.
const SHAFT_MM: f64 = 1.5;
const HEAD: f64 = 0.25;

/// An arrow for every point of a fit, in machine axes; gives the magnification. Both topics have the same, so that they compare.
pub fn arrows(
    writer: &mut FoxgloveWriter,
    residuals: &Residuals,
    asked: Option<f64>,
) -> Result<f64, RecordError> {
    let used: Vec<&ResidualPoint> = residuals.points.iter().filter(|point| !point.excluded).collect();
    let magnification = asked.unwrap_or_else(|| trunnion_report::magnification(&used));
    for (k, point) in residuals.points.iter().enumerate() {
        let time_s = shown_s(point.time_s, k * residuals.every);
        let setup = residuals.setups.get(point.setup).map_or("", |setup| &setup.name);
        let shifts = [
            (MEASURED, BLUE, point.in_machine.measured_um),
            (RESIDUAL, ORANGE, point.in_machine.residual_um()),
        ];
        for (channel, color, shift_um) in shifts {
            let color = if point.excluded { GREY } else { color };
            let shift_um = Vector3::from(shift_um);
            let Some(arrow) = arrow(point, &shift_um, magnification, color) else { continue };
            let about = [
                ("setup", setup),
                ("um", &format!("{:.2} {:.2} {:.2}", shift_um.x, shift_um.y, shift_um.z)),
                ("magnification", &magnification.to_string()),
                ("excluded", if point.excluded { "yes" } else { "no" }),
            ];
            let entity = SceneEntity {
                timestamp: Some(writer.moment(time_s)),
                frame_id: "machine".into(),
                id: format!("point {}", k * residuals.every),
                metadata: metadata(&about),
                arrows: vec![arrow],
                ..SceneEntity::default()
            };
            writer.write(channel, time_s, &SceneUpdate { entities: vec![entity], deletions: Vec::new() })?;
        }
    }
    Ok(magnification)
}

/// `None` where there is nothing to draw.
fn arrow(
    point: &ResidualPoint,
    shift_um: &Vector3<f64>,
    magnification: f64,
    color: Color,
) -> Option<ArrowPrimitive> {
    let drawn_mm = shift_um.map(mm_from_um) * magnification;
    let length_mm = drawn_mm.norm();
    if !length_mm.is_normal() {
        return None;
    }
    // An arrow points along x; opposite to it any half turn does.
    let along = UnitQuaternion::rotation_between(&Vector3::x(), &drawn_mm)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI));
    Some(ArrowPrimitive {
        pose: Some(pose(&Point3::from(point.in_machine.commanded_mm), &along)),
        shaft_length: metres(length_mm * (1.0 - HEAD)),
        shaft_diameter: metres(SHAFT_MM),
        head_length: metres(length_mm * HEAD),
        head_diameter: metres(2.0 * SHAFT_MM),
        color: Some(color),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arrow_leads_from_the_commanded_place_along_the_error() {
        for shift_um in [[3.0, -4.0, 12.0], [1.0, 0.0, 0.0], [-2.0, 0.0, 0.0]].map(Vector3::from) {
            let mut point = ResidualPoint::default();
            point.in_machine.commanded_mm = [100.0, 20.0, 3.0];
            let arrow = arrow(&point, &shift_um, 1000.0, BLUE).unwrap();
            let pose = arrow.pose.unwrap();
            let q = pose.orientation.unwrap();
            let rotation = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q.w, q.x, q.y, q.z));
            let tip_m = rotation * Vector3::x() * (arrow.shaft_length + arrow.head_length);
            // 1 µm a thousand times is 1 mm.
            assert!((tip_m - shift_um * 1e-3).norm() < 1e-12, "{shift_um} {tip_m}");
            assert_eq!(pose.position.unwrap().x, 0.1);
        }
        assert!(arrow(&ResidualPoint::default(), &Vector3::zeros(), 1000.0, BLUE).is_none());
    }
}
