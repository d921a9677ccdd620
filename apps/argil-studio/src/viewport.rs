//! The viewport: the image, its overlays, and the pointer's actions in it.

use crate::overlay::label;
use crate::picking::Picked;
use crate::render_worker::{RenderAnswer, RenderRequest};
use crate::session::{Request, Session};
use crate::view::{Tool, ViewState};
use crate::viewport_images::*;
use crate::viewport_renderer::ViewportPaint;
use argil::glam::{Vec2, Vec3};
use argil::scene::{NodeId, OperatorKind, Shape};
use eframe::egui::{self, Color32, PointerButton, Pos2, Rect, Sense, Stroke};
use web_time::Instant;

impl ViewState {
    /// Shows the viewport.
    pub(crate) fn ui(&mut self, session: &mut Session, ui: &mut egui::Ui) {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Viewport"));
        self.pictures.size = Vec2::new(rect.width(), rect.height());
        self.pictures.pixels_per_point = ui.ctx().pixels_per_point();
        self.take_answer(session);
        self.draw_pictures(ui, rect, session.preferences.grid);
        if session.preferences.grid {
            self.draw_triad(ui, rect);
        }
        self.draw_outlines(session, ui, rect);
        self.draw_mirrors(session, ui, rect);
        let divides = self.divide(ui, rect);
        let has_gizmo = !divides && self.gizmo(session, ui, rect, &response);
        self.point(session, ui, rect, &response, divides || has_gizmo);
        self.keys(ui, &response);
        if session.preferences.readings {
            self.draw_readings(session, ui, rect);
        }
        if let Some(fault) = &self.pictures.fault {
            let at = rect.left_center() + egui::vec2(20.0, 0.0);
            label(ui, at, &format!("Cannot render: {fault}"));
        }
    }

    pub(crate) fn take_answer(&mut self, session: &mut Session) {
        if session.renderer.is_gone() {
            let fault = "internal error. Save the scene, and restart Argil Studio";
            self.pictures.fault = Some(fault.into());
        }
        let Some(answer) = session.renderer.answer() else {
            return;
        };
        let RenderAnswer {
            request,
            pictures,
            duration_ms,
        } = answer;
        let pixels = f64::from(request.size[0] * request.size[1]);
        let pictures = match pictures {
            Ok(pictures) => pictures,
            Err(error) => {
                self.pictures.fault = Some(error);
                self.pictures.last = Some(request);
                return;
            }
        };
        self.pictures.fault = None;
        self.pictures.duration_ms = duration_ms;
        if !request.is_still {
            self.pictures.ms_per_pixel = Some(duration_ms / pixels.max(1.0));
            // However long it took: starting a final image now would delay the next interaction.
            self.pictures.moved = Some(Instant::now());
        }
        let textures = match &mut self.pictures.renderer {
            Some((renderer, pool)) => renderer.show(&pictures, pool),
            None => Ok(None),
        };
        match textures {
            Ok(textures) => self.pictures.textures = textures,
            Err(error) => self.pictures.fault = Some(error.to_string()),
        }
        self.pictures.shown = pictures;
        let edits = self.pictures.shown.iter().filter_map(|s| s.edit_ms);
        if let Some(ms) = edits.reduce(f64::max) {
            self.pictures.edit_ms = Some(ms);
        }
        self.pictures.last = Some(request);
    }

    /// Requests an image if the last one is outdated.
    pub(crate) fn ask_for_picture(&mut self, session: &mut Session, ctx: &egui::Context) {
        let view = &self.pictures;
        let pixels = view.size * view.pixels_per_point;
        if pixels.min_element() < 1.0 {
            return;
        }
        let mut pipelines = vec![session.preferences.pipeline];
        pipelines.extend(view.split.filter(|p| *p != session.preferences.pipeline));
        // A screen may have more pixels than the device can render at once.
        let most = session.renderer.max_pixels() as f32;
        let fits = (most / (pixels.x * pixels.y)).sqrt().min(1.0);
        let full = [pixels.x, pixels.y].map(|n| ((fits * n) as u32).clamp(1, 4096));
        let request = |size: [u32; 2], is_still: bool| RenderRequest {
            pipelines: pipelines.clone(),
            show: self.show,
            resolution: session.preferences.resolution,
            camera: self.eye.camera(),
            size,
            is_still,
            traces_paths: self.traces_paths,
            counts_rays: session.preferences.readings,
            version: session.version,
        };
        let wanted = request(full, true);
        if view.last.as_ref() == Some(&wanted) {
            // After a fault, what is shown is of an earlier scene.
            let is_whole =
                view.fault.is_some() || view.shown.iter().all(|shown| shown.missing == 0);
            self.pictures.is_settled = is_whole;
            if !is_whole && !session.renderer.is_busy() {
                session.renderer.draw(wanted);
            }
            return;
        }
        let is_other = view.last.as_ref().is_none_or(|last| {
            RenderRequest {
                size: full,
                is_still: true,
                ..last.clone()
            } != wanted
        });
        if is_other && view.is_settled || view.moved.is_none() {
            self.pictures.moved = Some(Instant::now());
        }
        self.pictures.is_settled = false;
        if session.renderer.is_busy() {
            return;
        }
        if is_other && self.pictures.last.is_some() {
            self.pictures.moved = Some(Instant::now());
            let scale = self.pictures.scale(f64::from(full[0]) * f64::from(full[1]));
            let size = full.map(|n| ((f64::from(n) * scale) as u32).max(1));
            session.renderer.draw(request(size, false));
            return;
        }
        let rested = self.pictures.moved.map_or(REST, |at| at.elapsed());
        if rested >= REST || self.pictures.last.is_none() {
            // A slow image is first rendered with one sample, so that the next interaction does not wait for all
            // samples.
            let is_long = self
                .pictures
                .is_long(f64::from(full[0]) * f64::from(full[1]));
            let is_sharp = self.pictures.last.as_ref().is_none_or(|l| l.size == full);
            let is_last = is_sharp || !is_long;
            session.renderer.draw(request(full, is_last));
        } else {
            ctx.request_repaint_after(REST - rested);
        }
    }

    /// Draws the images, and the grid over them if it is asked for.
    pub(crate) fn draw_pictures(&self, ui: &egui::Ui, rect: Rect, has_grid: bool) {
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 0.0, Color32::from_gray(40));
        let view = &self.pictures;
        if let (Some((renderer, _)), Some(shown)) = (&view.renderer, &view.textures) {
            let are_two = view.shown.len() > 1;
            let paint = ViewportPaint {
                renderer: renderer.clone(),
                shown: shown.clone(),
                camera: self.eye,
                divider: if are_two { view.divider } else { 1.0 },
                shows_difference: are_two && view.shows_difference,
                size: Vec2::new(rect.width(), rect.height()),
                lines: if has_grid { self.grid() } else { Vec::new() },
            };
            painter.add(paint.into_shape(rect));
        }
    }

    /// Shows the divider of a split view. Returns true if it uses the pointer.
    pub(crate) fn divide(&mut self, ui: &egui::Ui, rect: Rect) -> bool {
        if self.pictures.shown.len() < 2 || self.pictures.shows_difference {
            return false;
        }
        let x = rect.left() + self.pictures.divider * rect.width();
        let grip = Rect::from_x_y_ranges(x - 5.0..=x + 5.0, rect.y_range());
        let response = ui.interact(grip, ui.scope_id().with("divider"), Sense::drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, "Divider"));
        if response.dragged()
            && let Some(at) = response.interact_pointer_pos()
        {
            self.pictures.divider = ((at.x - rect.left()) / rect.width()).clamp(0.02, 0.98);
        }
        let is_held = response.hovered() || response.dragged();
        let width = if is_held { 3.0 } else { 1.5 };
        let painter = ui.painter_at(rect);
        painter.vline(x, rect.y_range(), Stroke::new(width, Color32::WHITE));
        if is_held {
            ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
        }
        for (shown, left) in self.pictures.shown.iter().zip([x - 80.0, x + 12.0]) {
            let at = Pos2::new(left, rect.bottom() - 30.0);
            label(ui, at, &shown.pipeline.label());
        }
        is_held
    }

    /// Draws outlines of the selection and of the node under the pointer.
    pub(crate) fn draw_outlines(&mut self, session: &mut Session, ui: &egui::Ui, rect: Rect) {
        let mut all: Vec<(NodeId, bool)> = session
            .document
            .selection
            .iter()
            .map(|&n| (n, true))
            .collect();
        let is_sculpting = self.tool == Tool::Sculpt;
        if let Some(node) = self.hovered.filter(|_| !is_sculpting) {
            all.push((node, false));
        }
        if all.len() > MAX_OUTLINED || self.sculpting.is_going() {
            return;
        }
        let stands = self.eye.camera().eye;
        for (node, is_selected) in all {
            let scene = session.document.scene();
            if !session.document.has(node) {
                continue;
            }
            let takes_away = scene.node(node).desc().operator.kind == OperatorKind::Subtract;
            let color = match (takes_away, is_selected) {
                (true, _) => Color32::from_rgb(255, 110, 90),
                (false, true) => Color32::from_rgb(255, 200, 60),
                (false, false) => Color32::from_rgb(160, 210, 255),
            };
            let stroke = Stroke::new(if is_selected { 1.5 } else { 1.0 }, color);
            let Some(outline) = session.picker.outline(scene, node) else {
                continue;
            };
            let painter = ui.painter_at(rect);
            for [a, b] in outline.seen_from(stands) {
                let at = |p| {
                    let at = self.eye.project(p, self.pictures.size)?;
                    Some(rect.min + egui::vec2(at.x, at.y))
                };
                if let (Some(a), Some(b)) = (at(a), at(b)) {
                    painter.line_segment([a, b], stroke);
                }
            }
        }
    }

    pub(crate) fn ray_at(&self, rect: Rect, at: Pos2) -> [Vec3; 2] {
        let in_view = at - rect.min;
        self.eye
            .ray(Vec2::new(in_view.x, in_view.y), self.pictures.size)
    }

    pub(crate) fn picked(&mut self, session: &mut Session, rect: Rect, at: Pos2) -> Option<Picked> {
        let ray = self.ray_at(rect, at);
        let document = &session.document;
        let may = |node| !document.is_locked(node);
        session
            .picker
            .pick((document.scene(), session.version), ray, may)
    }

    /// Handles the pointer where neither a gizmo nor the divider uses it.
    pub(crate) fn point(
        &mut self,
        session: &mut Session,
        ui: &egui::Ui,
        rect: Rect,
        response: &egui::Response,
        is_taken: bool,
    ) {
        let (held, delta, at) = ui.input(|i| {
            let delta = i.pointer.delta();
            let at = i.pointer.latest_pos();
            (i.modifiers, Vec2::new(delta.x, delta.y), at)
        });
        // A shape dropped from the gallery goes to the surface under the pointer.
        if let Some(shape) = response.dnd_release_payload::<Shape>()
            && let Some(at) = at
        {
            let ray = self.ray_at(rect, at);
            let scene = (session.document.scene(), session.version);
            let place = match session.picker.cast(scene, ray) {
                Some(hit) => Vec3::from(hit.point),
                None => ray[0] + ray[1] * self.eye.distance,
            };
            self.add_shape(session, (*shape).clone(), place);
        }
        if response.contains_pointer() {
            let (scroll, zoom) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
            if scroll != 0.0 || zoom != 1.0 {
                self.eye.zoom((-0.003 * scroll).exp() / zoom);
            }
        }
        let sculpts = self.tool == Tool::Sculpt && !held.alt;
        if sculpts && !is_taken {
            self.sculpt_at(session, ui, rect, response, at);
        }
        let height = rect.height().max(1.0);
        let primary = response.dragged_by(PointerButton::Primary)
            && !is_taken
            && self.drag.is_none()
            && !self.sculpting.is_going()
            && (!sculpts || held.alt);
        let middle = response.dragged_by(PointerButton::Middle);
        let secondary = response.dragged_by(PointerButton::Secondary);
        if held.shift && (primary || middle || secondary) {
            self.eye.pan(delta / height);
        } else if secondary {
            self.eye.look(Vec2::new(0.15 * delta.x, 0.15 * delta.y));
        } else if primary || middle {
            self.eye.orbit(Vec2::new(-0.4 * delta.x, 0.4 * delta.y));
        }
        if response.clicked() && !is_taken && !sculpts {
            let found = at.and_then(|at| self.picked(session, rect, at));
            let node = found.map(|found| found.node);
            session.document.select(node, held.command || held.shift);
            if let Some(node) = node {
                session.requests.push(Request::Reveal(node));
            }
        }
        // The node under the pointer is determined only when the pointer rests.
        let is_calm = delta == Vec2::ZERO && !ui.input(|i| i.pointer.any_down());
        if !response.hovered() || is_taken {
            self.hovered = None;
        } else if is_calm && ui.input(|i| i.pointer.time_since_last_movement()) < 0.5 {
            self.hovered = at
                .and_then(|at| self.picked(session, rect, at))
                .map(|f| f.node);
        }
    }

    pub(crate) fn sculpt_at(
        &mut self,
        session: &mut Session,
        ui: &egui::Ui,
        rect: Rect,
        response: &egui::Response,
        at: Option<Pos2>,
    ) {
        let pressure = ui.input(|i| {
            i.events.iter().rev().find_map(|event| match event {
                egui::Event::Touch { force, .. } => *force,
                _ => None,
            })
        });
        #[cfg(target_arch = "wasm32")]
        let pressure = pressure.or_else(crate::browser::pen_pressure);
        self.forget_material(session);
        let is_down = response.is_pointer_button_down_on()
            && ui.input(|i| i.pointer.button_down(PointerButton::Primary));
        let Some(at) = at.filter(|_| response.contains_pointer() || is_down) else {
            self.end_sculpting(session);
            return;
        };
        let ray = self.ray_at(rect, at);
        let scene = (session.document.scene(), session.version);
        let hit = session.picker.cast(scene, ray);
        if let Some(hit) = &hit {
            let point = Vec3::from(hit.point);
            let pixels = self.eye.pixels_per_unit(point, self.pictures.size);
            let radius = self.sculpting.radius * pixels;
            let painter = ui.painter_at(rect);
            painter.circle_stroke(at, radius, Stroke::new(1.5, Color32::from_white_alpha(180)));
        }
        if ui.input(|i| i.key_pressed(egui::Key::Escape)) {
            self.cancel_sculpting(session);
        }
        if !is_down {
            self.end_sculpting(session);
        } else if let Some(hit) = hit.filter(|_| !self.sculpting.is_given_up()) {
            let (point, normal) = (Vec3::from(hit.point), Vec3::from(hit.normal));
            session.attempt(|s| self.sculpt(s, point, normal, pressure.unwrap_or(1.0)));
        }
    }

    /// Handles flying while the right button is held.
    pub(crate) fn keys(&mut self, ui: &egui::Ui, response: &egui::Response) {
        if !response.dragged_by(PointerButton::Secondary) {
            return;
        }
        let (by, dt) = ui.input(|i| {
            let down = |key| f32::from(u8::from(i.key_down(key)));
            let by = Vec3::new(
                down(egui::Key::D) - down(egui::Key::A),
                down(egui::Key::E) - down(egui::Key::Q),
                down(egui::Key::W) - down(egui::Key::S),
            );
            (by, i.stable_dt.min(0.1))
        });
        if by != Vec3::ZERO {
            self.eye.fly(by * dt * self.eye.distance);
            ui.ctx().request_repaint();
        }
    }

    pub(crate) fn draw_readings(&self, session: &mut Session, ui: &egui::Ui, rect: Rect) {
        let mut lines = vec![session.renderer.device()];
        for p in &self.pictures.shown {
            lines.push(format!(
                "{} · {}×{} · frame {:.1} ms",
                p.pipeline.label(),
                p.size[0],
                p.size[1],
                p.frame_ms
            ));
            lines.extend(p.steps.map(|steps| {
                format!(
                    "steps {:.1} · p95 {:.0} · max {:.0}",
                    steps.mean, steps.p95, steps.max
                )
            }));
            let mut held = format!("{:.1} MiB", p.memory_bytes as f64 / f64::from(1 << 20));
            if let Some(bricks) = p.bricks {
                held += &format!(" · {bricks} bricks");
            }
            if let Some(paths) = p.paths {
                held = format!("{paths} paths a pixel");
            } else if p.missing > 0 {
                held += &format!(" · {} missing", p.missing);
            }
            if p.lost > 0 {
                held += &format!(" · {} not in the store", p.lost);
            }
            if let Some(triangles) = p.triangles {
                held += &format!(" · {triangles} triangles");
            }
            lines.push(held);
        }
        if let Some(ms) = self.pictures.edit_ms {
            lines.push(format!("last edit {ms:.1} ms"));
        }
        label(ui, rect.min + egui::vec2(10.0, 10.0), &lines.join("\n"));
    }
}
