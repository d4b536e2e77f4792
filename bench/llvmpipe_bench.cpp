// Mesa's llvmpipe, a software OpenGL driver, drawing the facets in the order in which the blend target draws them, into
// render targets of the same size and formats. It gets what suits it best: colours computed beforehand, where the blend
// target shades, and the arrangement of vertices that it draws fastest (see FlatMesh).
#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
#include <benchmark/benchmark.h>
#include <stdlib.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "benchmarks.h"
#include "facetsort/blend/rasteriser.h"
#include "facetsort/blend/shading.h"
#include "facetsort/order/sorter.h"
#include "subjects.h"
#include "thread_counts.h"

namespace facetsort::bench {
namespace {

constexpr int picture_size = 1024;

// llvmpipe moves vertices to a grid of 1/256 of a pixel before it decides what a facet covers, the blend target leaves
// them where they are: the two may differ where an edge passes that near a pixel's centre. Small facets and many layers
// make more such pixels: 0.2 % of the covered ones on bunny_70k, 0.6 % on dragon_871k.
constexpr double differing_share_allowed = 0.02;
// llvmpipe rounds the source to 8 bits before each blend and the blend target after it: a step and a half a layer, and
// each layer over it halves that, where alpha is a half.
constexpr float steps_allowed_rgba8 = 3.5f, steps_allowed_rgba32f = 1;

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// The facets as OpenGL draws them with one colour each: flat shading takes it from a facet's first vertex. Vertex i is
// the first corner of facet i; facets take their other corners from their neighbours. So there are as many vertices as
// facets, and a few for corners that are first in no facet.
struct FlatMesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
};

FlatMesh flat_mesh(const Mesh& mesh) {
  constexpr std::uint32_t none = ~0u;
  const std::size_t facets = mesh.triangles.size();
  FlatMesh flat{std::vector<glm::vec3>(facets), mesh.triangles};
  std::vector<std::uint32_t> vertex_at(mesh.positions.size(), none);
  for (std::size_t facet = 0; facet < facets; ++facet) {
    glm::uvec3& corners = flat.triangles[facet];
    int first = 0;
    while (first < 3 && vertex_at[corners[first]] != none) ++first;
    first %= 3;
    corners = {corners[first], corners[(first + 1) % 3], corners[(first + 2) % 3]};
    if (vertex_at[corners[0]] == none) vertex_at[corners[0]] = static_cast<std::uint32_t>(facet);
    flat.positions[facet] = mesh.positions[corners[0]];
  }
  for (std::size_t facet = 0; facet < facets; ++facet) {
    glm::uvec3& corners = flat.triangles[facet];
    corners[0] = static_cast<std::uint32_t>(facet);
    for (const int corner : {1, 2}) {
      std::uint32_t& vertex = vertex_at[corners[corner]];
      if (vertex == none) {
        vertex = static_cast<std::uint32_t>(flat.positions.size());
        flat.positions.push_back(mesh.positions[corners[corner]]);
      }
      corners[corner] = vertex;
    }
  }
  return flat;
}

constexpr const char* vertex_shader = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 facet_colour;
uniform mat4 clip_from_mesh;
flat out vec4 colour;
void main() {
  gl_Position = clip_from_mesh * vec4(position, 1);
  colour = facet_colour;
})";

constexpr const char* fragment_shader = R"(#version 330 core
flat in vec4 colour;
out vec4 fragment;
void main() { fragment = colour; })";

// To OpenGL's clip space, pixel row 0 of the blend target at OpenGL's row 0. Depth is 0: nothing is tested or cut off.
glm::mat4 clip_from_mesh(const Camera& camera) {
  const glm::dvec3 x = camera.row_x * (2.0 / camera.width) - camera.row_w;
  const glm::dvec3 y = camera.row_y * (2.0 / camera.height) - camera.row_w;
  const double offset_x = camera.offset.x * (2.0 / camera.width) - camera.offset.z - glm::dot(x, camera.eye);
  const double offset_y = camera.offset.y * (2.0 / camera.height) - camera.offset.z - glm::dot(y, camera.eye);
  const double offset_w = camera.offset.z - glm::dot(camera.row_w, camera.eye);
  return glm::mat4(glm::transpose(
      glm::dmat4(glm::dvec4(x, offset_x), glm::dvec4(y, offset_y), glm::dvec4(0), glm::dvec4(camera.row_w, offset_w))));
}

// OSMesa keeps the context's own picture in the caller's memory; here that is one pixel, as all is drawn off screen.
class Context {
 public:
  explicit Context(int threads) {
    // Read once, when the process makes its first context: all benchmarks use the same number of threads.
    setenv("GALLIUM_DRIVER", "llvmpipe", 1);
    setenv("LP_NUM_THREADS", std::to_string(threads).c_str(), 1);
    constexpr int attributes[] = {OSMESA_FORMAT,
                                  OSMESA_RGBA,
                                  OSMESA_PROFILE,
                                  OSMESA_CORE_PROFILE,
                                  OSMESA_CONTEXT_MAJOR_VERSION,
                                  3,
                                  OSMESA_CONTEXT_MINOR_VERSION,
                                  3,
                                  0};
    context_ = OSMesaCreateContextAttribs(attributes, nullptr);
    if (!context_ || !OSMesaMakeCurrent(context_, pixel_, GL_UNSIGNED_BYTE, 1, 1)) {
      if (context_) OSMesaDestroyContext(context_);
      throw std::runtime_error("OSMesa gives no OpenGL 3.3 context");
    }
  }
  ~Context() { OSMesaDestroyContext(context_); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

 private:
  OSMesaContext context_ = nullptr;
  unsigned char pixel_[4] = {};
};

GLuint linked_program() {
  const GLuint program = glCreateProgram();
  for (const auto& [stage, source] :
       {std::pair{GL_VERTEX_SHADER, vertex_shader}, std::pair{GL_FRAGMENT_SHADER, fragment_shader}}) {
    const GLuint shader = glCreateShader(static_cast<GLenum>(stage));
    glShaderSource(shader, 1, &source, nullptr);
    glCompileShader(shader);
    glAttachShader(program, shader);
    glDeleteShader(shader);
  }
  glLinkProgram(program);
  GLint linked = GL_FALSE;
  glGetProgramiv(program, GL_LINK_STATUS, &linked);
  if (!linked) throw std::runtime_error("OpenGL refuses the shaders");
  return program;
}

// Owns a context; what it makes in it goes with it.
class Llvmpipe {
 public:
  Llvmpipe(const FlatMesh& mesh, PixelFormat format, int threads) : context_(threads), program_(linked_program()) {
    glUseProgram(program_);
    GLuint vertex_array = 0, positions = 0, colours = 0, indices = 0, render_target = 0, framebuffer = 0;
    glGenVertexArrays(1, &vertex_array);
    glBindVertexArray(vertex_array);
    glGenBuffers(1, &positions);
    glBindBuffer(GL_ARRAY_BUFFER, positions);
    glBufferData(GL_ARRAY_BUFFER, bytes(mesh.positions), mesh.positions.data(), GL_STATIC_DRAW);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    glEnableVertexAttribArray(0);
    glGenBuffers(1, &colours);
    glBindBuffer(GL_ARRAY_BUFFER, colours);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.positions.size() * sizeof(glm::vec4)), nullptr,
                 GL_DYNAMIC_DRAW);
    glVertexAttribPointer(1, 4, GL_FLOAT, GL_FALSE, 0, nullptr);
    glEnableVertexAttribArray(1);
    glGenBuffers(1, &indices);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices);
    glGenRenderbuffers(1, &render_target);
    glBindRenderbuffer(GL_RENDERBUFFER, render_target);
    glRenderbufferStorage(GL_RENDERBUFFER, format == PixelFormat::rgba8 ? GL_RGBA8 : GL_RGBA32F, picture_size,
                          picture_size);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, render_target);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      throw std::runtime_error("OpenGL can't draw into this pixel format");
    }
    glViewport(0, 0, picture_size, picture_size);
    glProvokingVertex(GL_FIRST_VERTEX_CONVENTION);
    glDisable(GL_DITHER);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    glClearColor(background.r, background.g, background.b, background.a);
  }

  void set_view(const View& view, const std::vector<glm::vec4>& colours) {
    glBufferSubData(GL_ARRAY_BUFFER, 0, bytes(colours), colours.data());
    const glm::mat4 matrix = clip_from_mesh(Camera(view));
    glUniformMatrix4fv(glGetUniformLocation(program_, "clip_from_mesh"), 1, GL_FALSE, &matrix[0][0]);
  }

  void set_indices(const std::vector<glm::uvec3>& triangles) {
    index_count_ = static_cast<GLsizei>(3 * triangles.size());
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, bytes(triangles), triangles.data(), GL_STREAM_DRAW);
    glFinish();
  }

  void draw() {
    glClear(GL_COLOR_BUFFER_BIT);
    glDrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
    glFinish();
  }

  std::vector<glm::vec4> picture() const {
    std::vector<glm::vec4> pixels(std::size_t{picture_size} * picture_size);
    glReadPixels(0, 0, picture_size, picture_size, GL_RGBA, GL_FLOAT, pixels.data());
    return pixels;
  }

  bool is_llvmpipe() const {
    const GLubyte* name = glGetString(GL_RENDERER);
    return name && std::string_view(reinterpret_cast<const char*>(name)).starts_with("llvmpipe");
  }
  bool has_error() const { return glGetError() != GL_NO_ERROR; }

 private:
  template <typename T>
  static GLsizeiptr bytes(const std::vector<T>& elements) {
    return static_cast<GLsizeiptr>(elements.size() * sizeof(T));
  }

  Context context_;
  GLuint program_;
  GLsizei index_count_ = 0;
};

// Share of the covered pixels in which the pictures differ by more than rounding explains.
double differing_share(const std::vector<glm::vec4>& picture, const Image& expected) {
  const float allowed = (expected.format == PixelFormat::rgba8 ? steps_allowed_rgba8 : steps_allowed_rgba32f) / 255.0f;
  std::size_t covered = 0, differing = 0;
  for (std::size_t i = 0; i < picture.size(); ++i) {
    covered += expected.pixels[i] != background || picture[i] != background;
    const glm::vec4 difference = glm::abs(picture[i] - expected.pixels[i]);
    differing += !glm::all(glm::lessThanEqual(difference, glm::vec4(allowed)));  // what is no number differs
  }
  return static_cast<double>(differing) / static_cast<double>(std::max<std::size_t>(covered, 1));
}

void draw_frames(benchmark::State& state, const Subject& subject, PixelFormat format, int threads) {
  const Mesh& mesh = subject.mesh();
  MeshView facets = mesh.view();
  facets.vertex_colours = {};  // one colour a facet
  const FlatMesh flat = flat_mesh(mesh);
  Llvmpipe peer(flat, format, threads);
  if (!peer.is_llvmpipe()) throw std::runtime_error("OSMesa draws with another driver");
  Sorter sorter(facets, Method::centroid_distance);
  std::span<const std::uint32_t> order;
  std::vector<glm::vec4> colours;
  std::vector<glm::uvec3> triangles(facets.facet_count());
  const std::vector<View> frames = frames_around(mesh, picture_size);
  // One thread: workers that wait for more to do would take processors from llvmpipe.
  tbb::task_arena arena(1);
  const auto prepare = [&](const View& view) {
    arena.execute([&] {
      order = sorter.sort({view.homogeneous_eye(), view.forward()});
      facet_colours(facets, view.homogeneous_eye(), colours);
    });
    std::transform(order.begin(), order.end(), triangles.begin(), [&](std::uint32_t id) { return flat.triangles[id]; });
    peer.set_view(view, colours);
  };
  prepare(frames[0]);
  peer.set_indices(triangles);
  peer.draw();  // compiles the shaders to machine code
  std::size_t frame = 0;
  double upload_seconds = 0;
  for (auto _ : state) {
    prepare(frames[frame++ % frames.size()]);
    const auto begin = std::chrono::steady_clock::now();
    peer.set_indices(triangles);
    const double uploaded = seconds_since(begin);
    peer.draw();
    state.SetIterationTime(seconds_since(begin) - uploaded);
    upload_seconds += uploaded;
  }
  const View& last = frames[(frame + frames.size() - 1) % frames.size()];
  const DrawPass pass;
  Image expected;
  Rasteriser().draw(facets, last, order, colours, {&pass, 1}, background, format, expected);
  const double differing = differing_share(peer.picture(), expected);
  if (peer.has_error()) state.SkipWithError("OpenGL reports an error");
  if (differing > differing_share_allowed) state.SkipWithError("another picture than the blend target's");
  state.counters["upload_ms"] = benchmark::Counter(1e3 * upload_seconds, benchmark::Counter::kAvgIterations);
  state.counters["differing"] = differing;
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(facets.facet_count()));
}

void draw_or_say_why_not(benchmark::State& state, const Subject& subject, PixelFormat format, int threads) {
  try {
    draw_frames(state, subject, format, threads);
  } catch (const std::runtime_error& fault) {
    state.SkipWithError(fault.what());
  }
}

}  // namespace

void register_llvmpipe_benchmarks() {
  std::vector<Subject> subjects = shipped_meshes();
  for (const Subject& knot : knots(1000, 1000000)) subjects.push_back(knot);
  for (const Subject& subject : subjects) {
    for (const PixelFormat format : {PixelFormat::rgba32f, PixelFormat::rgba8}) {
      const auto run = [=](benchmark::State& state, int threads) {
        draw_or_say_why_not(state, subject, format, threads);
      };
      register_per_thread_count(
          std::string("llvmpipe_draw") + (format == PixelFormat::rgba8 ? "/rgba8/" : "/rgba32f/") + subject.name(), run,
          Clock::manual, {thread_counts().back()});
    }
  }
}

}  // namespace facetsort::bench
