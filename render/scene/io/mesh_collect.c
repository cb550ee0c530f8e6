/* SPDX-License-Identifier: Apache-2.0 */
/* Assimp's tree of nodes into one mesh. */
#include "render/scene/io/mesh_collect.h"

#include "core/checked.h"
#include "core/rng.h"
#include "core/vec.h"

enum { NODE_DEPTH_MAX = 200 };

/* One walk counts, a second one fills: the limits are checked before anything is allocated. */
typedef struct Collector {
    Reader *reader;
    const char *place;
    const struct aiScene *scene;
    MeshTriangles *out;
    size_t vertices, triangles, visits;
    bool fill, all_have_normals;
} Collector;

static Affine node_matrix(const struct aiMatrix4x4 *m) {
    return (Affine){{{(double)m->a1, (double)m->a2, (double)m->a3, (double)m->a4},
        {(double)m->b1, (double)m->b2, (double)m->b3, (double)m->b4},
        {(double)m->c1, (double)m->c2, (double)m->c3, (double)m->c4}}};
}

static bool is_identity(const Affine *a) {
    Affine one = affine_identity();
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            if (a->m[r][c] != one.m[r][c]) return false;
    return true;
}

static V3 vector_of(const struct aiVector3D *v) { return v3((double)v->x, (double)v->y, (double)v->z); }

static cau_result count_faces(Collector *c, const struct aiMesh *mesh) {
    for (unsigned f = 0; f < mesh->mNumFaces; f++) {
        const struct aiFace *face = &mesh->mFaces[f];
        if (face->mNumIndices < 3)
            return error_set(c->reader->err, CAU_ERROR_INPUT,
                "%s: face %u has %u corners; points and lines cannot be rendered, or the file is cut off",
                c->place, f, face->mNumIndices);
        for (unsigned i = 0; i < face->mNumIndices; i++)
            if (face->mIndices[i] >= mesh->mNumVertices)
                return error_set(c->reader->err, CAU_ERROR_INPUT,
                    "%s: face %u uses vertex %u; there are only %u", c->place, f, face->mIndices[i],
                    mesh->mNumVertices);
        c->triangles += face->mNumIndices - 2;
    }
    c->vertices += mesh->mNumVertices;
    c->all_have_normals &= mesh->mNormals != NULL;
    return CAU_OK;
}

static cau_result put_face(Collector *c, const struct aiFace *face, bool turned) {
    size_t n = face->mNumIndices;
    uint32_t small[4], *corners = n <= 4 ? small : array_new(n, sizeof *corners);
    uint32_t *out = &c->out->indices[3 * c->triangles];
    if (!corners)
        return error_set(c->reader->err, CAU_ERROR_RESOURCE, "%s: out of memory for a face", c->place);
    for (size_t i = 0; i < n; i++)
        corners[turned ? n - 1 - i : i] = (uint32_t)(c->vertices + face->mIndices[i]);
    cau_result result = polygon_triangulate(c->reader, c->place, c->out->positions, corners, n, out);
    if (corners != small) free(corners);
    c->triangles += n - 2;
    return result;
}

static cau_result put_mesh(Collector *c, const struct aiMesh *mesh, const Affine *matrix) {
    bool moved = !is_identity(matrix), turned = affine_determinant(matrix) < 0;
    for (size_t i = 0; i < mesh->mNumVertices; i++) {
        V3 p = vector_of(&mesh->mVertices[i]);
        if (moved) p = affine_point(matrix, p);
        double *out = &c->out->positions[3 * (c->vertices + i)];
        out[0] = p.x;
        out[1] = p.y;
        out[2] = p.z;
        if (!c->out->normals) continue;
        V3 n = vector_of(&mesh->mNormals[i]);
        if (moved) n = v3_scale(affine_normal(matrix, n), turned ? -1 : 1);
        double length = v3_length(n);
        if (length > 0) n = v3_scale(n, 1 / length);
        float *normal = &c->out->normals[3 * (c->vertices + i)];
        normal[0] = (float)n.x;
        normal[1] = (float)n.y;
        normal[2] = (float)n.z;
    }
    c->out->doubles |= moved;
    for (unsigned f = 0; f < mesh->mNumFaces; f++) CAU_TRY(put_face(c, &mesh->mFaces[f], turned));
    c->vertices += mesh->mNumVertices;
    return CAU_OK;
}

static cau_result walk(Collector *c, const struct aiNode *node, const Affine *above, int depth) {
    if (depth > NODE_DEPTH_MAX)
        return error_set(c->reader->err, CAU_ERROR_INPUT, "%s: its nodes are nested deeper than %d", c->place,
            NODE_DEPTH_MAX);
    Affine own = node_matrix(&node->mTransformation), here = affine_compose(above, &own);
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        if (node->mMeshes[i] >= c->scene->mNumMeshes)
            return error_set(c->reader->err, CAU_ERROR_INPUT, "%s: a node uses mesh %u; there are only %u",
                c->place, node->mMeshes[i], c->scene->mNumMeshes);
        const struct aiMesh *mesh = c->scene->mMeshes[node->mMeshes[i]];
        CAU_TRY(c->fill ? put_mesh(c, mesh, &here) : count_faces(c, mesh));
        if (c->vertices > UINT32_MAX || c->triangles > UINT32_MAX)
            return error_set(
                c->reader->err, CAU_ERROR_INPUT, "%s: more than 4294967295 vertices or triangles", c->place);
    }
    for (unsigned i = 0; i < node->mNumChildren; i++) CAU_TRY(walk(c, node->mChildren[i], &here, depth + 1));
    return CAU_OK;
}

cau_result mesh_collect(
    Reader *r, const char *place, const struct aiScene *scene, bool y_up, MeshTriangles *out) {
    /* Exact in single precision: coordinates change places. */
    const Affine upright = {{{1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}}}, as_is = affine_identity();
    Collector c = {.reader = r, .place = place, .scene = scene, .out = out, .all_have_normals = true};
    if (!scene->mRootNode) return error_set(r->err, CAU_ERROR_INPUT, "%s: holds no mesh", place);
    CAU_TRY(walk(&c, scene->mRootNode, &as_is, 0));
    if (c.triangles == 0) return error_set(r->err, CAU_ERROR_INPUT, "%s: holds no faces", place);
    *out = (MeshTriangles){.vertex_count = c.vertices, .triangle_count = c.triangles, .split = true};
    out->positions = array_new(c.vertices, 3 * sizeof *out->positions);
    out->normals = c.all_have_normals ? array_new(c.vertices, 3 * sizeof *out->normals) : NULL;
    out->indices = array_new(c.triangles, 3 * sizeof *out->indices);
    if (!out->positions || !out->indices || (c.all_have_normals && !out->normals))
        return error_set(
            r->err, CAU_ERROR_RESOURCE, "%s: out of memory for %zu triangles", place, c.triangles);
    c.fill = true;
    c.vertices = c.triangles = 0;
    return walk(&c, scene->mRootNode, y_up ? &upright : &as_is, 0);
}

/* Assimp gives OBJ corners vertices of their own, which would leave nothing to smooth over. */
bool mesh_weld(MeshTriangles *m) {
    size_t capacity = 16, kept = 0;
    while (capacity < 2 * m->vertex_count) capacity *= 2;
    uint32_t *table = array_new(capacity, sizeof *table), *same = array_new(m->vertex_count, sizeof *same);
    bool ok = table && same;
    for (size_t i = 0; ok && i < m->vertex_count; i++) {
        double p[3];
        uint64_t bits[3];
        for (int c = 0; c < 3; c++) p[c] = m->positions[3 * i + (size_t)c] + 0.0; /* -0 becomes 0 */
        memcpy(bits, p, sizeof p);
        size_t slot = (size_t)rng_combine(rng_combine(bits[0], bits[1]), bits[2]) & (capacity - 1);
        while (table[slot] && memcmp(&m->positions[3 * (size_t)(table[slot] - 1)], p, sizeof p) != 0)
            slot = (slot + 1) & (capacity - 1);
        if (!table[slot]) {
            memcpy(&m->positions[3 * kept], p, sizeof p);
            table[slot] = (uint32_t)++kept;
        }
        same[i] = table[slot] - 1;
    }
    for (size_t i = 0; ok && i < 3 * m->triangle_count; i++) m->indices[i] = same[m->indices[i]];
    if (ok) m->vertex_count = kept;
    free(table);
    free(same);
    return ok;
}

void mesh_triangles_free(MeshTriangles *m) {
    free(m->positions);
    free(m->normals);
    free(m->indices);
    *m = (MeshTriangles){0};
}
