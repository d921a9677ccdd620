//! The outliner: the list of brushes and groups, in order of evaluation.

use crate::commands::Command;
use crate::document::Document;
use crate::icon::{self, Icon};
use crate::names::name_of;
use crate::session::Session;
use argil::scene::{Edit, NodeId, NodeKind, OperatorKind, Scene};
use eframe::egui::{self, Align, Layout, RichText, Sense, Vec2};

/// A row.
struct OutlinerRow {
    node: NodeId,
    depth: usize,
}

/// Where a dragged row is dropped.
enum DropTarget {
    Before,
    Into,
    After,
}

/// The outliner.
#[derive(Default)]
pub(crate) struct Outliner {
    renaming: Option<(argil::scene::NodeId, String)>,
    collapsed: std::collections::BTreeSet<argil::scene::NodeId>,
    /// The node whose row to scroll to.
    revealed: Option<argil::scene::NodeId>,
}

impl Outliner {
    /// Resets the state for another document.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Collapses a group.
    pub(crate) fn fold(&mut self, group: NodeId) {
        self.collapsed.insert(group);
    }

    /// Starts renaming the active node.
    pub(crate) fn begin_renaming(&mut self, document: &Document) {
        if let Some(node) = document.active() {
            let name = document.scene().node(node).desc().name.clone();
            self.renaming = Some((node, name));
            self.reveal(document, node, true);
        }
    }

    /// Scrolls to a node's row. Expands its groups, or scrolls to the collapsed group that contains it.
    pub(crate) fn reveal(&mut self, document: &Document, node: NodeId, opens: bool) {
        let mut shown = node;
        let mut around = document.scene().node(node).parent();
        while let Some(group) = around {
            if opens {
                self.collapsed.remove(&group);
            } else if self.collapsed.contains(&group) {
                shown = group;
            }
            around = document.scene().node(group).parent();
        }
        self.revealed = Some(shown);
    }

    fn rows(&self, scene: &Scene) -> Vec<OutlinerRow> {
        fn within(
            scene: &Scene,
            group: NodeId,
            depth: usize,
            outliner: &Outliner,
            out: &mut Vec<OutlinerRow>,
        ) {
            for &node in scene.node(group).children() {
                out.push(OutlinerRow { node, depth });
                if !outliner.collapsed.contains(&node) {
                    within(scene, node, depth + 1, outliner, out);
                }
            }
        }
        let mut out = Vec::new();
        within(scene, Scene::ROOT, 0, self, &mut out);
        out
    }

    pub(crate) fn ui(&mut self, session: &mut Session, ui: &mut egui::Ui, most: f32) {
        let rows = self.rows(session.document.scene());
        let height = ui.spacing().interact_size.y;
        let mut area = egui::ScrollArea::vertical()
            .id_salt("list")
            .auto_shrink(false)
            .max_height(most);
        if let Some(node) = self.revealed.take()
            && let Some(at) = rows.iter().position(|row| row.node == node)
        {
            let pitch = height + ui.spacing().item_spacing.y;
            let above = 0.5 * ui.available_height().min(most);
            area = area.vertical_scroll_offset((at as f32 * pitch - above).max(0.0));
        }
        area.show_rows(ui, height, rows.len(), |ui, range| {
            for row in &rows[range] {
                self.row(session, ui, row, &rows);
            }
        });
    }

    fn row(
        &mut self,
        session: &mut Session,
        ui: &mut egui::Ui,
        row: &OutlinerRow,
        rows: &[OutlinerRow],
    ) {
        let node = row.node;
        let entry = session.document.scene().node(node).desc().clone();
        let is_group = matches!(entry.kind, NodeKind::Group);
        let name = name_of(&entry);
        ui.push_id(node.index(), |ui| {
            ui.horizontal(|ui| {
                ui.add_space(12.0 * row.depth as f32);
                if is_group {
                    let is_open = !self.collapsed.contains(&node);
                    let icon = if is_open { Icon::Down } else { Icon::Right };
                    let button =
                        icon::button(ui, icon, true, &format!("Expand or collapse {name}"));
                    if button.clicked() && !self.collapsed.remove(&node) {
                        self.collapsed.insert(node);
                    }
                } else {
                    ui.add_space(icon::side(ui) + ui.spacing().item_spacing.x);
                }
                let is_renamed = matches!(&self.renaming, Some((n, _)) if *n == node);
                if is_renamed {
                    self.rename(session, ui);
                    return;
                }
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    self.row_switches(session, ui, node, entry.visible, &name);
                    let response = self.row_name(session, ui, node, &entry);
                    self.drag_and_drop(session, ui, row, is_group, &response);
                    if response.double_clicked() {
                        self.renaming = Some((node, entry.name.clone()));
                    } else if response.clicked() {
                        let held = ui.input(|i| i.modifiers);
                        choose(&mut session.document, node, held, rows);
                    }
                    response.context_menu(|ui| self.row_menu(session, ui, node));
                });
            });
        });
    }

    fn row_switches(
        &mut self,
        session: &mut Session,
        ui: &mut egui::Ui,
        node: NodeId,
        visible: bool,
        name: &str,
    ) {
        let is_locked = session.document.scene().node(node).desc().locked;
        let words = format!("Lock or unlock {name}");
        if icon::button(ui, Icon::Lock(is_locked), true, &words).clicked() {
            session.attempt(|s| s.document.lock(&[node], !is_locked));
        }
        let words = format!("Hide or show {name}");
        if icon::button(ui, Icon::Eye(visible), true, &words).clicked() {
            let word = if visible { "Hide" } else { "Show" };
            let edit = Edit::SetVisible {
                node,
                visible: !visible,
            };
            session.attempt(|s| s.document.edit(word, edit).map(drop));
        }
    }

    fn row_name(
        &self,
        session: &mut Session,
        ui: &mut egui::Ui,
        node: NodeId,
        entry: &argil::scene::NodeDesc,
    ) -> egui::Response {
        let sign = match entry.operator.kind {
            OperatorKind::Union => "+",
            OperatorKind::Subtract => "−",
            OperatorKind::Intersect => "&",
            OperatorKind::Paint => "•",
            OperatorKind::Morph => "~",
        };
        let name = name_of(entry);
        let mut text = RichText::new(format!("{sign} {name}"));
        if !entry.visible {
            text = text.weak();
        }
        let is_selected = session.document.selection.contains(&node);
        let button = egui::Button::selectable(is_selected, text)
            .truncate()
            .sense(Sense::click_and_drag());
        let size = Vec2::new(ui.available_width(), ui.spacing().interact_size.y);
        let left = Layout::left_to_right(Align::Center).with_main_justify(true);
        let response = ui
            .allocate_ui_with_layout(size, left.with_main_align(Align::Min), |ui| ui.add(button))
            .inner;
        response.widget_info(|| {
            egui::WidgetInfo::selected(egui::Role::Button, true, is_selected, name.clone())
        });
        response
    }

    fn drag_and_drop(
        &mut self,
        session: &mut Session,
        ui: &egui::Ui,
        row: &OutlinerRow,
        is_group: bool,
        response: &egui::Response,
    ) {
        if !session.document.is_locked(row.node) {
            response.dnd_set_drag_payload(row.node);
        }
        let place = || {
            let at = ui.input(|i| i.pointer.interact_pos())?;
            let part = (at.y - response.rect.top()) / response.rect.height();
            Some(match part {
                p if p < 0.3 || (!is_group && p < 0.5) => DropTarget::Before,
                p if p > 0.7 || !is_group => DropTarget::After,
                _ => DropTarget::Into,
            })
        };
        if response.dnd_hover_payload::<NodeId>().is_some()
            && let Some(place) = place()
        {
            let rect = response.rect;
            let stroke = ui.visuals().selection.stroke;
            match place {
                DropTarget::Before => _ = ui.painter().hline(rect.x_range(), rect.top(), stroke),
                DropTarget::After => {
                    _ = ui.painter().hline(rect.x_range(), rect.bottom(), stroke);
                }
                DropTarget::Into => {
                    let inside = egui::StrokeKind::Inside;
                    ui.painter().rect_stroke(rect, 2.0, stroke, inside);
                }
            }
        }
        if let Some(dragged) = response.dnd_release_payload::<NodeId>()
            && let Some(place) = place()
        {
            session.attempt(|s| drop_at(&mut s.document, *dragged, row.node, &place));
        }
    }

    fn rename(&mut self, session: &mut Session, ui: &mut egui::Ui) {
        let Some((node, mut text)) = self.renaming.take() else {
            return;
        };
        let response = ui.text_edit_singleline(&mut text);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, "Name"));
        if response.lost_focus() {
            let is_given_up = ui.input(|i| i.key_pressed(egui::Key::Escape));
            let mut entry = session.document.scene().node(node).desc().clone();
            if !is_given_up && entry.name != text {
                entry.name = text;
                session.attempt(|s| s.document.replace("Rename", node, entry));
            }
            return;
        }
        response.request_focus();
        self.renaming = Some((node, text));
    }

    fn row_menu(&mut self, session: &mut Session, ui: &mut egui::Ui, node: NodeId) {
        if !session.document.selection.contains(&node) {
            session.document.select(Some(node), false);
        }
        for command in [
            Command::Rename,
            Command::Duplicate,
            Command::Group,
            Command::Ungroup,
            Command::Hide,
            Command::Lock,
            Command::FrameSelection,
            Command::Delete,
        ] {
            session.command_button(ui, command);
        }
    }
}

/// Shows the undo history.
pub(crate) fn history(document: &mut Document, ui: &mut egui::Ui) {
    ui.separator();
    ui.strong("History");
    let (names, done) = document.history();
    let names = names.to_vec();
    let mut go_to = None;
    let height = ui.spacing().interact_size.y;
    egui::ScrollArea::vertical()
        .id_salt("history")
        .auto_shrink(false)
        .stick_to_bottom(true)
        .show_rows(ui, height, names.len() + 1, |ui, range| {
            for i in range {
                let name = if i == 0 {
                    "Original state"
                } else {
                    &names[i - 1]
                };
                let text = if i > done {
                    RichText::new(name).weak()
                } else {
                    RichText::new(name)
                };
                if ui.selectable_label(i == done, text).clicked() {
                    go_to = Some(i);
                }
            }
        });
    if let Some(steps) = go_to {
        document.go_to(steps);
    }
}

fn choose(document: &mut Document, node: NodeId, held: egui::Modifiers, rows: &[OutlinerRow]) {
    if !held.shift {
        document.select(Some(node), held.command);
        return;
    }
    // Select the range from the last selected row to this one.
    let at = |n: NodeId| rows.iter().position(|r| r.node == n);
    let (Some(to), Some(from)) = (at(node), document.active().and_then(at)) else {
        document.select(Some(node), false);
        return;
    };
    for row in &rows[from.min(to)..=from.max(to)] {
        if !document.selection.contains(&row.node) {
            document.selection.push(row.node);
        }
    }
}

/// Moves the dragged nodes before, into or after a node.
fn drop_at(
    document: &mut Document,
    dragged: NodeId,
    target: NodeId,
    place: &DropTarget,
) -> anyhow::Result<()> {
    let mut all = if document.selection.contains(&dragged) {
        document.movable()
    } else {
        vec![dragged]
    };
    all.retain(|&n| n != target);
    if all.is_empty() {
        return Ok(());
    }
    document.begin_stroke("Reorder");
    for (i, node) in all.into_iter().enumerate() {
        let scene = document.scene();
        let around = scene.node(target).parent().unwrap_or(Scene::ROOT);
        let (parent, mut index) = match place {
            DropTarget::Into => (target, scene.node(target).children().len()),
            DropTarget::Before | DropTarget::After => {
                let siblings = scene.node(around).children();
                let at = siblings.iter().position(|&n| n == target).unwrap_or(0);
                let behind = usize::from(matches!(place, DropTarget::After));
                (around, at + behind * (1 + i))
            }
        };
        // The index does not count the moved node itself.
        let siblings = scene.node(parent).children();
        if let Some(before) = siblings.iter().position(|&n| n == node)
            && before < index
        {
            index -= 1;
        }
        let edit = Edit::Move {
            node,
            parent,
            index,
        };
        document.edit("Reorder", edit)?;
    }
    document.end_stroke();
    Ok(())
}
