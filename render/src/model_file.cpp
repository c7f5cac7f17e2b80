// SPDX-License-Identifier: MIT
#include <assimp/DefaultIOSystem.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>

#include "gltf.hpp"
#include "handyar/io/error.hpp"
#include "handyar/render/model.hpp"
#include "material_file.hpp"
#include "motion.hpp"
#include "ply.hpp"
#include "uri.hpp"

namespace handyar::render {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& fault) {
  throw io::Error(path.string(), fault);
}

std::string first_line(std::string text) { return text.substr(0, text.find_first_of("\r\n")); }

// Files beside a model.
class Files : public Assimp::DefaultIOSystem {
 public:
  Assimp::IOStream* Open(const char* name, const char* mode) override {
    return DefaultIOSystem::Open(file_named(name).c_str(), mode);
  }
};

Mesh read_mesh(const aiMesh& in, const aiMaterial& material, const TextureTransform& by,
               const Mesh::Moment& first) {
  Mesh out;
  const bool linear = states_linear_light(material);
  const unsigned coordinates = by.coordinates.value_or(texture_coordinates_of(material));
  for (unsigned i = 0; i < in.mNumVertices; ++i) {
    Vertex v{first.positions[i], first.normals[i]};
    if (in.HasVertexColors(0)) v.colour = srgb(in.mColors[0][i], linear);
    if (in.HasTextureCoords(coordinates))
      v.uv = by.laid * Eigen::Vector2f(in.mTextureCoords[coordinates][i].x,
                                       in.mTextureCoords[coordinates][i].y);
    out.vertices.push_back(v);
  }
  for (unsigned i = 0; i < in.mNumFaces; ++i) {
    const aiFace& face = in.mFaces[i];
    if (face.mNumIndices == 3)
      out.indices.insert(out.indices.end(), face.mIndices, face.mIndices + 3);
  }
  return out;
}

/// A mesh where it is used: a file may have it at several nodes.
struct Use {
  const aiMesh* mesh;
  const aiNode* node;
};

void find_uses(const aiScene& scene, const aiNode& node, std::vector<Use>& uses) {
  for (unsigned i = 0; i < node.mNumMeshes; ++i)
    uses.push_back({scene.mMeshes[node.mMeshes[i]], &node});
  for (unsigned i = 0; i < node.mNumChildren; ++i) find_uses(scene, *node.mChildren[i], uses);
}

/// How many moments tell a motion: so many a second, but of large models fewer, for memory's sake.
int moment_count(double period_s, const std::vector<Use>& uses) {
  constexpr double kPerSecond = 20, kMostVertices = 4e6;
  double vertices = 1;
  for (const Use& use : uses) vertices += use.mesh->mNumVertices;
  return static_cast<int>(std::ceil(std::min(kPerSecond * period_s, kMostVertices / vertices)));
}

// assimp's own steps take it for granted that faces have corners, and that these are there.
bool has_broken_face(const aiScene& scene) {
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[i];
    for (unsigned k = 0; k < mesh.mNumFaces; ++k) {
      const aiFace& face = mesh.mFaces[k];
      const auto beyond = [&](unsigned corner) { return corner >= mesh.mNumVertices; };
      if (face.mNumIndices == 0 ||
          std::any_of(face.mIndices, face.mIndices + face.mNumIndices, beyond))
        return true;
    }
  }
  return false;
}

// Some programs write normals without having any: assimp is to make its own.
bool has_null_normals(const aiScene& scene) {
  const auto is_null = [](const aiVector3D& normal) { return normal.SquareLength() == 0; };
  return std::any_of(scene.mMeshes, scene.mMeshes + scene.mNumMeshes, [&](const aiMesh* mesh) {
    const aiVector3D* const first = mesh->mNormals;
    return first != nullptr && std::all_of(first, first + mesh->mNumVertices, is_null);
  });
}

bool has_bones(const aiScene& scene) {
  return std::any_of(scene.mMeshes, scene.mMeshes + scene.mNumMeshes,
                     [](const aiMesh* mesh) { return mesh->HasBones(); });
}

// Of what is drawn, at all times.
bool all_finite(const Model& model) {
  return std::all_of(model.meshes.begin(), model.meshes.end(), [](const Mesh& mesh) {
    const auto finite = [](const Eigen::Vector3f& position) { return position.allFinite(); };
    return std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                       [&](const Vertex& v) { return finite(v.position); }) &&
           std::all_of(mesh.moments.begin(), mesh.moments.end(), [&](const Mesh::Moment& moment) {
             return std::all_of(moment.positions.begin(), moment.positions.end(), finite);
           });
  });
}

}  // namespace

Model load_model(const fs::path& path) {
  if (!std::ifstream(path)) fail(path, "no such model (a file, or one of: teapot, bunny)");
  if (is_ply_cut_short(path)) fail(path, "breaks off: its header states more than there is");
  const std::vector<TextureTransform> laid = read_gltf(path);
  Assimp::Importer importer;
  importer.SetIOHandler(new Files);  // which it deletes
  // Points and lines have no surface: they are dropped.
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, aiComponent_NORMALS);
  const aiScene* scene = importer.ReadFile(path.string(), 0);
  if (scene && has_broken_face(*scene)) fail(path, "has a face with a corner that is not there");
  unsigned steps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_GenSmoothNormals |
                   aiProcess_FlipUVs | aiProcess_FindDegenerates;
  // Of corners that it joins assimp adds up the weights that bones have on them.
  if (scene && !has_bones(*scene)) steps |= aiProcess_JoinIdenticalVertices;
  if (scene && has_null_normals(*scene)) steps |= aiProcess_RemoveComponent;
  if (scene) scene = importer.ApplyPostProcessing(steps);
  if (!scene) fail(path, "cannot be read as a model: " + first_line(importer.GetErrorString()));
  std::vector<Use> uses;
  find_uses(*scene, *scene->mRootNode, uses);
  Model model;
  const NodePlaces first(*scene, 0);
  std::map<const aiMaterial*, Material> materials;  // whose textures take time and memory once
  for (const auto& [mesh, node] : uses) {
    const aiMaterial& material = *scene->mMaterials[mesh->mMaterialIndex];
    const unsigned which = mesh->mMaterialIndex;
    model.meshes.push_back(read_mesh(*mesh, material,
                                     which < laid.size() ? laid[which] : TextureTransform{},
                                     moment(*mesh, *node, first)));
    const auto [known, is_new] = materials.try_emplace(&material);
    if (is_new) known->second = read_material(*scene, material, path);
    model.meshes.back().material = known->second;
  }
  model.period_s = period_s(*scene);
  const int count = moment_count(model.period_s, uses);
  for (int k = 0; k < count; ++k) {
    const NodePlaces places(*scene, static_cast<double>(k) / count);
    for (std::size_t i = 0; i < uses.size(); ++i)
      model.meshes[i].moments.push_back(moment(*uses[i].mesh, *uses[i].node, places));
  }
  std::erase_if(model.meshes, [](const Mesh& mesh) { return mesh.indices.empty(); });
  if (!all_finite(model)) fail(path, "has a corner that is, or moves to, no finite place");
  if (model.meshes.empty() || !(model.bounds().sizes().maxCoeff() > 0))
    fail(path, "holds no surface to draw");
  return model;
}

}  // namespace handyar::render
