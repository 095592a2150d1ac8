/* Times VolPack's shear-warp on a classified volume of bytes: a frame for every line on standard input, whose seconds are
 * printed as JSON, as tools/peers/timing.py does it. One thread. A frame is a new shading table, and a rendering.
 *
 *     volpack VOLUME WIDTH HEIGHT DEPTH EDGE FAINT END PICTURE
 *
 * VOLUME holds bytes, x fastest. Opacity is a ramp of density, shading a look-up of the normal, the picture a square of grey bytes
 * that holds the volume's longest edge. Opacities up to FAINT are dropped, and rays end at the opacity END. The material and the light are those of VolPack's own example, without depth cue. */

#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <volpack.h>

enum { NORMAL, DENSITY, FIELDS };
enum { WARM_UP = 2, DENSITIES = 256 };

struct voxel {
    short normal;
    unsigned char density;
};

static void require(vpContext *vp, vpResult result)
{
    if (result != VP_OK) {
        fprintf(stderr, "volpack: %s\n", vpGetErrorString(vpGetError(vp)));
        exit(1);
    }
}

static void *memory(size_t bytes)
{
    void *got = calloc(bytes, 1);
    if (got == NULL) {
        fprintf(stderr, "volpack: %zu bytes are not to be had\n", bytes);
        exit(1);
    }
    return got;
}

static unsigned char *bytes_of(const char *path, size_t count)
{
    unsigned char *bytes = memory(count);
    FILE *file = fopen(path, "rb");
    if (file == NULL || fread(bytes, 1, count, file) != count) {
        fprintf(stderr, "volpack: %s has no %zu bytes\n", path, count);
        exit(1);
    }
    fclose(file);
    return bytes;
}

/* Clear up to a density of 30, opaque from 60 on. */
static void classify(vpContext *vp, double faint)
{
    static float opacity[DENSITIES];
    int x[] = {0, 30, 60, 255};
    float y[] = {0, 0, 1, 1};
    require(vp, vpRamp(opacity, sizeof(float), 4, x, y));
    require(vp, vpSetClassifierTable(vp, 0, DENSITY, opacity, sizeof opacity));
    require(vp, vpSetd(vp, VP_MIN_VOXEL_OPACITY, faint));
    require(vp, vpClassifyVolume(vp));
}

static void load(vpContext *vp, const char *path, const int *dims, double faint)
{
    struct voxel *any = NULL;
    size_t count = (size_t)dims[0] * dims[1] * dims[2];
    unsigned char *densities = bytes_of(path, count);
    int row = dims[0] * (int)sizeof(struct voxel);
    require(vp, vpSetVolumeSize(vp, dims[0], dims[1], dims[2]));
    require(vp, vpSetVoxelSize(vp, sizeof(struct voxel), FIELDS, FIELDS, 1));
    require(vp, vpSetVoxelField(vp, NORMAL, sizeof any->normal, vpFieldOffset(any, normal), VP_NORM_MAX));
    require(vp, vpSetVoxelField(vp, DENSITY, sizeof any->density, vpFieldOffset(any, density), DENSITIES - 1));
    require(vp, vpSetRawVoxels(vp, memory(count * sizeof(struct voxel)), count * sizeof(struct voxel), sizeof(struct voxel), row,
                               row * dims[1]));
    require(vp, vpVolumeNormals(vp, densities, count, DENSITY, VP_SKIP_FIELD, NORMAL));
    free(densities);
    classify(vp, faint);
}

static void light(vpContext *vp)
{
    static float table[VP_NORM_MAX + 1];
    require(vp, vpSetLookupShader(vp, 1, 1, NORMAL, table, sizeof table, 0, NULL, 0));
    require(vp, vpSetMaterial(vp, VP_MATERIAL0, VP_AMBIENT, VP_BOTH_SIDES, 0.18, 0.18, 0.18));
    require(vp, vpSetMaterial(vp, VP_MATERIAL0, VP_DIFFUSE, VP_BOTH_SIDES, 0.35, 0.35, 0.35));
    require(vp, vpSetMaterial(vp, VP_MATERIAL0, VP_SPECULAR, VP_BOTH_SIDES, 0.39, 0.39, 0.39));
    require(vp, vpSetMaterial(vp, VP_MATERIAL0, VP_SHINYNESS, VP_BOTH_SIDES, 8, 0, 0));
    require(vp, vpSetLight(vp, VP_LIGHT0, VP_DIRECTION, 0.3, 0.3, 1));
    require(vp, vpSetLight(vp, VP_LIGHT0, VP_COLOR, 1, 1, 1));
    require(vp, vpEnable(vp, VP_LIGHT0, 1));
    require(vp, vpEnable(vp, VP_LIGHT_BOTH_SIDES, 1));
}

static void look(vpContext *vp)
{
    require(vp, vpSeti(vp, VP_CONCAT_MODE, VP_CONCAT_LEFT));
    require(vp, vpRotate(vp, VP_Y_AXIS, 130));
    require(vp, vpRotate(vp, VP_X_AXIS, -15));
    require(vp, vpCurrentMatrix(vp, VP_PROJECT));
    require(vp, vpIdentityMatrix(vp));
    require(vp, vpWindow(vp, VP_PARALLEL, -0.5, 0.5, -0.5, 0.5, -0.5, 0.5));
    require(vp, vpCurrentMatrix(vp, VP_MODEL));
}

static void draw(vpContext *vp)
{
    require(vp, vpShadeTable(vp));
    require(vp, vpRenderClassifiedVolume(vp));
}

static double seconds(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return now.tv_sec + now.tv_nsec * 1e-9;
}

/* Turns a little and back, so that nothing of the frame before can be used again. */
static void turn(vpContext *vp, int n)
{
    require(vp, vpRotate(vp, VP_Y_AXIS, n % 2 ? -0.01 : 0.01));
}

static void serve(vpContext *vp)
{
    int c, n = 0;
    while ((c = getchar()) != EOF) {
        if (c != '\n')
            continue;
        double wall = seconds(CLOCK_MONOTONIC), cpu = seconds(CLOCK_PROCESS_CPUTIME_ID);
        turn(vp, n++);
        draw(vp);
        wall = seconds(CLOCK_MONOTONIC) - wall;
        cpu = seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu;
        printf("{\"wall_s\": %.9f, \"cpu_s\": %.9f}\n", wall, cpu);
        fflush(stdout);
    }
}

int main(int count, char **words)
{
    if (count != 9) {
        fprintf(stderr, "usage: volpack VOLUME WIDTH HEIGHT DEPTH EDGE FAINT END PICTURE\n");
        return 1;
    }
    int dims[] = {atoi(words[2]), atoi(words[3]), atoi(words[4])}, edge = atoi(words[5]);
    unsigned char *picture = memory((size_t)edge * edge);
    vpContext *vp = vpCreateContext();
    load(vp, words[1], dims, atof(words[6]));
    light(vp);
    look(vp);
    require(vp, vpSetd(vp, VP_MAX_RAY_OPACITY, atof(words[7])));
    require(vp, vpSetImage(vp, picture, edge, edge, edge, VP_LUMINANCE));
    for (int n = 0; n < WARM_UP; n++)
        draw(vp);
    FILE *file = fopen(words[8], "wb");
    if (file == NULL || fwrite(picture, 1, (size_t)edge * edge, file) != (size_t)edge * edge || fclose(file) != 0) {
        fprintf(stderr, "volpack: %s cannot be written\n", words[8]);
        return 1;
    }
    printf("{\"version\": \"%s\"}\n", VP_VERSION);
    fflush(stdout);
    serve(vp);
    return 0;
}
