// SPDX-License-Identifier: MIT
#pragma once

#include <array>

namespace handyar::render::shaders {

/// Common to all: the camera with its distortion. Row 0 of the target is the top row of the frame,
/// so that gl_FragCoord - 0.5 is the pixel in the frame.
inline constexpr char kCamera[] = R"(#version 140
uniform vec4 fc;         // fx, fy, cx, cy in pixels
uniform float k[5];      // k1, k2, p1, p2, k3
uniform float r2_max;    // beyond this the polynomial turns back
uniform vec2 size_px;

// What is not in front of the camera, or too far to the side for the distortion to mean anything,
// stays undistorted: that is linear in p, so that OpenGL clips edges where they leave the view.
vec4 project(vec3 p) {
  const float near = 0.01, far = 100.0;
  vec2 x_z = p.xy;  // as the lens bends it, times z
  float r2 = dot(p.xy, p.xy) / (p.z * p.z);
  if (p.z > 0.0 && r2 < r2_max) {
    vec2 x = p.xy / p.z;
    float radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
    x_z = p.z * (x * radial + vec2(2.0 * k[2] * x.x * x.y + k[3] * (r2 + 2.0 * x.x * x.x),
                                   k[2] * (r2 + 2.0 * x.y * x.y) + 2.0 * k[3] * x.x * x.y));
  }
  vec2 px_z = fc.xy * x_z + fc.zw * p.z;
  vec2 ndc_z = (px_z + 0.5 * p.z) / size_px * 2.0 - p.z;
  return vec4(ndc_z, (far + near) / (far - near) * p.z - 2.0 * far * near / (far - near), p.z);
}
)";

/// How much of a point at `p` (camera frame) the hand leaves to be seen.
inline constexpr char kHand[] = R"(#version 140
uniform sampler2D matte;        // coverage, rounding; over the region being drawn
uniform ivec2 matte_origin_px;
uniform int hand;               // 0 none, 1 nearer than everything, 2 in its plane
uniform vec3 hand_normal;       // of its visible face, camera frame
uniform float hand_offset_m;    // hand_normal . point of the plane
uniform float finger_radius_m;

vec2 hand_here() { return texelFetch(matte, ivec2(gl_FragCoord.xy) - matte_origin_px, 0).rg; }

float seen_past_hand(vec3 p) {
  if (hand == 0) return 1.0;
  vec2 here = hand_here();
  if (hand == 1) return 1.0 - here.r;
  // Height over the hand's surface, which rounds off towards the silhouette. Seen from the other
  // side (a pose held while the hand turns away), that surface is a finger's thickness deeper.
  float inside = 1.0 - here.g;
  float fall_m = finger_radius_m * (1.0 - sqrt(1.0 - inside * inside));
  float z_m = dot(hand_normal, p) - hand_offset_m;
  float above_m = fall_m + (hand_offset_m < 0.0 ? z_m : -z_m - 2.0 * finger_radius_m);
  return 1.0 - here.r * (1.0 - smoothstep(-0.002, 0.0, above_m));  // what lies on it is seen
}
)";

/// The inputs of kObjectVertex, in the order of their locations.
inline constexpr std::array kObjectAttributes{"position", "normal", "colour", "uv", "openness"};

inline constexpr char kObjectVertex[] = R"(
uniform mat4 T_camera_object;
uniform float size_m;
in vec3 position;
in vec3 normal;
in vec3 colour;
in vec2 uv;
in float openness;
out vec3 p;
out vec3 n;
out vec3 albedo;
out vec2 st;
out float open;
void main() {
  p = (T_camera_object * vec4(size_m * position, 1.0)).xyz;
  n = mat3(T_camera_object) * normal;
  albedo = colour * colour;
  st = uv;
  open = openness;
  gl_Position = project(p);
}
)";

inline constexpr char kObjectFragment[] = R"(
uniform sampler2D surface, emission_surface;
uniform bool textured, emission_textured;
uniform vec3 base_colour, emission;  // linear
uniform float roughness, metallic;
uniform float shine;       // Blinn's exponent for that roughness
uniform float opacity, glow;
uniform sampler2D ambient, mirrored;
uniform vec3 key, key_direction;
in vec3 p;
in vec3 n;
in vec3 albedo;
in vec2 st;
in float open;
out vec4 result;

/// The picture as a mirror ball: what a direction in the camera frame would see of it.
vec2 ball(vec3 d) { return 0.5 + 0.5 * d.xy / sqrt(2.0 * (1.0 + abs(d.z))) * 1.2; }

void main() {
  // Gamma 2 for sRGB throughout: a square and a root are cheap in software.
  vec3 own_light = emission;
  if (emission_textured) {  // read before anything is discarded: its mipmaps need the neighbours
    vec3 t = texture(emission_surface, st).rgb;
    own_light *= t * t;
  }
  vec4 base = vec4(albedo * base_colour, 1.0);
  if (textured) {
    vec4 t = texture(surface, st);
    base *= vec4(t.rgb * t.rgb, t.a);
    if (base.a < 0.5) discard;
  }
  vec3 view = normalize(-p);
  vec3 normal = normalize(n);
  if (dot(normal, view) < 0.0) normal = -normal;  // surfaces have two sides

  // Rough metal mirrors so much of the room at once that it looks like chalk of its colour.
  float mirrors = metallic * (1.0 - roughness * roughness);
  vec3 specular = mix(vec3(0.04), base.rgb, mirrors);
  vec3 diffuse = base.rgb * (1.0 - mirrors);
  float n_l = dot(normal, key_direction);
  // Wrapped a little: rooms have no point lights.
  float lit = max((n_l + 0.25) / 1.25, 0.0) * mix(0.45, 1.0, open);
  vec3 sky = texture(ambient, ball(normal)).rgb * open;
  vec3 colour = diffuse * (0.55 * sky + 0.75 * key * lit);

  float grazing = 1.0 - max(dot(normal, view), 0.0);
  float grazing2 = grazing * grazing;
  float fresnel = grazing2 * grazing2 * grazing;
  vec3 h = normalize(view + key_direction);
  float lobe = (shine + 8.0) / 25.0 * pow(max(dot(normal, h), 0.0), shine);
  vec3 mirror = texture(mirrored, ball(reflect(-view, normal))).rgb;
  float gloss = (1.0 - roughness) * (1.0 - roughness);
  colour += (specular + (1.0 - specular) * fresnel * gloss) *
            (mirror * open * mix(0.4, 1.0, gloss) + 0.6 * key * min(lobe, 12.0) * max(n_l, 0.0));

  colour += glow * (0.25 * base.rgb + vec3(1.0, 0.75, 0.25) * 0.9 * grazing2);
  colour += own_light;

  float alpha = opacity * seen_past_hand(p);
  result = vec4(sqrt(min(colour, 1.0)), 1.0) * alpha;
}
)";

/// A square of the ground around the foot of an object, from an even grid of 16x16 cells.
inline constexpr char kGroundVertex[] = R"(
uniform mat4 T_camera_object;
uniform float size_m;
out vec3 p;
out vec2 at;  // -1 .. 1, in sizes of the object
void main() {
  int cell = gl_VertexID / 6, corner = gl_VertexID % 6;
  ivec2 step_ = corner == 0 ? ivec2(0, 0) : corner == 1 || corner == 3 ? ivec2(1, 0)
              : corner == 2 || corner == 5 ? ivec2(0, 1) : ivec2(1, 1);
  at = vec2(ivec2(cell % 16, cell / 16) + step_) / 8.0 - 1.0;
  p = (T_camera_object * vec4(size_m * at, 0.0, 1.0)).xyz;
  gl_Position = project(p);
}
)";

inline constexpr char kGroundFragment[] = R"(
uniform sampler2D shadow;
uniform vec2 thrown;     // by how much the light moves the shadow of the whole, in sizes
uniform float strength; // of that shadow
uniform float shade;    // of all of it
uniform bool on_hand;
uniform float opacity, glow;
in vec3 p;
in vec2 at;
out vec4 result;
void main() {
  float touching = texture(shadow, at * 0.5 + 0.5).r;
  float whole = texture(shadow, (at - thrown) * 0.5 + 0.5).g;
  float edge = smoothstep(1.0, 0.75, max(abs(at.x), abs(at.y)));
  float dark = (1.0 - (1.0 - 0.55 * touching) * (1.0 - strength * whole)) * edge * shade;
  float ring = glow * smoothstep(0.10, 0.0, abs(length(at) - 0.62));
  float visible = opacity * (on_hand ? hand_here().r : seen_past_hand(p));
  result = vec4(vec3(1.0, 0.8, 0.3) * 0.8 * ring, max(dark, 0.8 * ring)) * visible;
}
)";

}  // namespace handyar::render::shaders
