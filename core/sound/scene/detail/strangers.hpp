#pragma once
#include "core/physics/fracture/dynamic/crack_mesh.hpp"
#include "core/sound/scene/detail/modal_body.hpp"

namespace klang::scene::detail {

/// Whether a modal and a cracking body, which do not feel one another, meet: a node of the one is in the other, or a corner of the modal one's
/// surface, or the middle of a triangle of it, in an element of the cracking one. Edges that cross between these are not seen.
bool meet(const ModalBody& body, const fracture::CrackMesh& mesh);

}  // namespace klang::scene::detail
