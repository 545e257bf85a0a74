//! The skins of a glTF file, joined into one skeleton.

use std::collections::HashMap;

use gltf::Document;
use nalgebra::Matrix4;

use super::super::rig::ImportError;
use super::accessor::numbers;
use super::file::Buffers;
use super::meshes::Meshes;
use super::nodes::Nodes;

/// Two bind matrices of one joint agree within this share of their largest entry; files round them.
const AGREE: f64 = 1e-4;

/// The joints of every skin that is read, each once.
pub(super) struct Skins {
    /// Node of each joint, J.
    pub(super) joints: Vec<usize>,
    /// World frame of each joint where the joined rest mesh is bound, J.
    pub(super) binds: Vec<Matrix4<f64>>,
    /// Their inverses.
    pub(super) inverse_binds: Vec<Matrix4<f64>>,
    /// Of each skin that a mesh has: numbers of its joints among the J.
    pub(super) members: HashMap<usize, Vec<usize>>,
}

impl Skins {
    /// Joins the skins of the meshes and moves each mesh to where the first one's joints bind it:
    /// exporters differ in whether all skins of a character share one space.
    ///
    /// # Errors
    /// [`ImportError::NoSkin`], [`ImportError::SingularBind`], [`ImportError::OtherBind`] and those
    /// of the bind matrices' accessor.
    pub(super) fn read(
        document: &Document,
        buffers: &Buffers,
        nodes: &Nodes,
        meshes: &mut Meshes,
    ) -> Result<Self, ImportError> {
        let mut all = Self {
            joints: Vec::new(),
            binds: Vec::new(),
            inverse_binds: Vec::new(),
            members: HashMap::new(),
        };
        let mut moved: HashMap<usize, Matrix4<f64>> = HashMap::new();
        for instance in 0..meshes.instances.len() {
            let mesh = meshes.instances[instance].name.clone();
            let number = meshes.instances[instance].skin;
            let skin = number.and_then(|number| document.skins().nth(number));
            let skin = skin.ok_or(ImportError::NoSkin)?;
            let number = skin.index();
            if !moved.contains_key(&number) {
                let (joints, own) = read_one(&skin, buffers, &mesh)?;
                let shared = joints.iter().zip(&own).find_map(|(node, own)| {
                    let joint = all.joints.iter().position(|joint| joint == node)?;
                    Some(all.binds[joint] * own)
                });
                let shift = shared.unwrap_or_else(Matrix4::identity);
                let singular =
                    |node: usize| ImportError::SingularBind { joint: nodes.names[node].clone() };
                let mut members = Vec::with_capacity(joints.len());
                for (&node, own) in joints.iter().zip(&own) {
                    let back = shift.try_inverse().ok_or_else(|| singular(node))?;
                    let inverse = own * back;
                    let joint = all.joints.iter().position(|&joint| joint == node);
                    let joint = match joint {
                        Some(joint) if !agree(&all.inverse_binds[joint], &inverse) => {
                            let joint = nodes.names[node].clone();
                            return Err(ImportError::OtherBind { mesh, joint });
                        }
                        Some(joint) => joint,
                        None => {
                            let bind = inverse.try_inverse().ok_or_else(|| singular(node))?;
                            all.joints.push(node);
                            all.binds.push(bind);
                            all.inverse_binds.push(inverse);
                            all.joints.len() - 1
                        }
                    };
                    members.push(joint);
                }
                all.members.insert(number, members);
                moved.insert(number, shift);
            }
            let vertices = meshes.vertices(instance);
            all.check_influences(&meshes.influences[vertices.clone()], number, &mesh)?;
            move_mesh(meshes, instance, &moved[&number]);
        }
        Ok(all)
    }

    /// Gives the nearest joint above each joint; several may have none.
    pub(super) fn parents(&self, nodes: &Nodes) -> Vec<Option<usize>> {
        let of = |node: usize| self.joints.iter().position(|&joint| joint == node);
        self.joints.iter().map(|&node| nodes.upwards(node).skip(1).find_map(of)).collect()
    }

    fn check_influences(
        &self,
        influences: &[Vec<(usize, f64)>],
        skin: usize,
        mesh: &str,
    ) -> Result<(), ImportError> {
        let members = self.members[&skin].len();
        let place = || format!("mesh {mesh}");
        for (vertex, influences) in influences.iter().enumerate() {
            if influences.is_empty() {
                return Err(ImportError::Unbound { mesh: mesh.to_owned(), vertex });
            }
            if let Some(&(joint, _)) = influences.iter().find(|(joint, _)| *joint >= members) {
                let (what, expected, found) = ("joints at most", members, joint + 1);
                return Err(ImportError::Count { place: place(), what, expected, found });
            }
        }
        Ok(())
    }
}

/// Reads the joints of a skin and their inverse bind matrices, which are none at all or one each.
fn read_one(
    skin: &gltf::Skin<'_>,
    buffers: &Buffers,
    mesh: &str,
) -> Result<(Vec<usize>, Vec<Matrix4<f64>>), ImportError> {
    let joints: Vec<usize> = skin.joints().map(|joint| joint.index()).collect();
    let Some(accessor) = skin.inverse_bind_matrices() else {
        let own = vec![Matrix4::identity(); joints.len()];
        return Ok((joints, own));
    };
    let own = numbers(&accessor, buffers, 16)?;
    let own: Vec<_> = own.chunks_exact(16).map(Matrix4::from_column_slice).collect();
    if own.len() < joints.len() {
        let (expected, found) = (joints.len(), own.len());
        let place = format!("the skin of mesh {mesh}");
        return Err(ImportError::Count { place, what: "inverse bind matrices", expected, found });
    }
    Ok((joints, own))
}

fn agree(a: &Matrix4<f64>, b: &Matrix4<f64>) -> bool {
    (a - b).amax() <= AGREE * a.amax()
}

fn move_mesh(meshes: &mut Meshes, instance: usize, shift: &Matrix4<f64>) {
    if *shift == Matrix4::identity() {
        return;
    }
    let vertices = meshes.vertices(instance);
    for position in &mut meshes.positions[vertices] {
        *position = shift.transform_point(&(*position).into()).into();
    }
    for displacement in meshes.instances[instance].morphs.iter_mut().flatten() {
        *displacement = shift.transform_vector(&(*displacement).into()).into();
    }
}
