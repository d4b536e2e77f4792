// How much a picture can be wrong where layers are blended in another order than theirs: what premultiplied source-over
// without a sort may cost where alphas are small.
#pragma once

#include <glm/glm.hpp>
#include <span>

namespace facetsort {

// How much the colour of two layers differs, a channel, when they are blended in the other order: with straight colours
// c1 and c2, a1 a2 |c1 - c2|. What lies in front makes it less, what lies behind changes nothing. Colours
// premultiplied.
glm::vec3 swap_error(const glm::vec4& layer1, const glm::vec4& layer2);

// How much the colours of any two orders of a pixel's layers may differ, a channel: no more than the swap errors of all
// pairs together, since any order becomes any other by swaps of neighbours, of each pair once at most; and no more than
// the range of the straight colours times the opacity of all layers together, since the layers are averaged with
// weights that sum to that in every order. Takes time with the square of the layers. Colours premultiplied.
glm::vec3 order_error_bound(std::span<const glm::vec4> layers);

}  // namespace facetsort
