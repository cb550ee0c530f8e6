/* SPDX-License-Identifier: Apache-2.0 */
/* The sliders' values out of a .blend file, which only Blender can read, or out of our own script. */
#include "composite/hosts/hosts.h"

#include "composite/hosts/scripts.h"
#include "core/checked.h"

#include <errno.h>
#include <fcntl.h>
#include <jansson.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

static const char answer[] = "CAUSTICS_RECIPE ", refusal[] = "CAUSTICS_ERROR ";

static bool is_blend(const char *data, size_t size) {
    static const char zstd[] = "\x28\xb5\x2f\xfd", gzip[] = "\x1f\x8b";
    return size > 12 &&
           (memcmp(data, "BLENDER", 7) == 0 || memcmp(data, zstd, 4) == 0 || memcmp(data, gzip, 2) == 0);
}

/* Python in the file is not run, nobody's settings are loaded; a signal to us is one to Blender too. */
static int start(const char *program, const char *path, int write_end, int read_end, pid_t *child) {
    const char *arguments[] = {program, "-b", "--factory-startup", "--disable-autoexec", path,
        "--python-exit-code", "3", "--python-expr", host_blender_read, NULL};
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t none;
    sigemptyset(&none);
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
    posix_spawn_file_actions_adddup2(&actions, write_end, STDOUT_FILENO);
    posix_spawn_file_actions_addclose(&actions, read_end);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    int failed =
        posix_spawnp(child, program, &actions, &attributes, (char *const *)(uintptr_t)arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    return failed;
}

/* The rest of the line that begins with `mark`, out of what Blender said; to be freed. */
static char *find_line(const char *said, const char *mark) {
    const char *at = strstr(said, mark);
    if (!at) return NULL;
    at += strlen(mark);
    return strndup(at, strcspn(at, "\n"));
}

static char *read_all(int fd) {
    char *text = NULL, buffer[4096];
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) return NULL;
    for (ssize_t n; (n = read(fd, buffer, sizeof buffer)) != 0;)
        if (n > 0)
            fwrite(buffer, 1, (size_t)n, out);
        else if (errno != EINTR)
            break;
    if (fclose(out) == 0) return text;
    free(text);
    return NULL;
}

static cau_result run(char **out, const char *program, const char *path, CauError *err) {
    int ends[2], status = 0;
    pid_t child;
    if (pipe2(ends, O_CLOEXEC) != 0)
        return error_set(err, CAU_ERROR_RESOURCE, "cannot make a pipe: %s", strerror(errno));
    int failed = start(program, path, ends[1], ends[0], &child);
    close(ends[1]);
    char *said = failed ? NULL : read_all(ends[0]);
    close(ends[0]);
    while (!failed && waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (failed)
        return error_set(err, CAU_ERROR_INPUT,
            "only Blender reads its files, and \"%s\" cannot be run (%s): name it in the environment "
            "variable "
            "BLENDER",
            program, strerror(failed));
    if (!said) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for what Blender says");
    *out = find_line(said, answer);
    char *why = find_line(said, refusal);
    free(said);
    if (!*out) error_set(err, CAU_ERROR_INPUT, "%s", why ? why : "Blender could not read the file");
    free(why);
    return *out ? CAU_OK : CAU_ERROR_INPUT;
}

static cau_result read_blend(Lights *out, const char *path, CauError *err) {
    const char *named = getenv("BLENDER");
    char *recipe = NULL, *whole = realpath(path, NULL); /* a name that begins with - is no option */
    cau_result result = whole ? run(&recipe, named && *named ? named : "blender", whole, err)
                              : error_set(err, CAU_ERROR_INPUT, "%s", strerror(errno));
    free(whole);
    if (result == CAU_OK) result = host_read_recipe(out, recipe, "the group node", err);
    free(recipe);
    return result;
}

/* Our script's lights as a recipe. */
static char *recipe_of(const json_t *shot) {
    json_t *lights = json_object(), *light;
    size_t i;
    static const char *const keys[] = {"gain", "ev", "tint", "mute", "solo", "saturation"};
    json_array_foreach(json_object_get(shot, "lights"), i, light) {
        const char *label = json_string_value(json_object_get(light, "label"));
        json_t *setting = json_object();
        for (size_t k = 0; k < sizeof keys / sizeof *keys; k++)
            if (!json_is_null(json_object_get(light, keys[k])))
                json_object_set(setting, keys[k], json_object_get(light, keys[k]));
        json_object_set_new(lights, label ? label : "", setting);
    }
    json_t *root = json_pack("{s:i, s:o}", "caustics_recipe", 1, "lights", lights);
    json_t *space = json_object_get(shot, "tint_space");
    if (json_is_string(space)) json_object_set(root, "tint_space", space);
    char *text = json_dumps(root, JSON_COMPACT);
    json_decref(root);
    return text;
}

static cau_result read_our_script(Lights *out, const char *text, CauError *err) {
    static const char begin[] = "SHOT = json.loads(r'''";
    const char *at = strstr(text, begin), *end = at ? strstr(at + sizeof begin - 1, "''')") : NULL;
    json_t *shot =
        end ? json_loadb(at + sizeof begin - 1, (size_t)(end - at) - (sizeof begin - 1), 0, NULL) : NULL;
    if (!shot)
        return error_set(err, CAU_ERROR_INPUT,
            "it is neither a Blender file nor a script that caustic-merge blender wrote");
    char *recipe = recipe_of(shot);
    json_decref(shot);
    cau_result result = recipe ? host_read_recipe(out, recipe, "its lights", err)
                               : error_set(err, CAU_ERROR_RESOURCE, "out of memory for a recipe");
    free(recipe);
    return result;
}

cau_result host_read_blender(Lights *out, const char *path, CauError *err) {
    char head[16] = "", *text = NULL;
    size_t size;
    FILE *file = fopen(path, "rbe");
    if (!file) return error_set(err, CAU_ERROR_INPUT, "cannot read \"%s\": %s", path, strerror(errno));
    bool blend = is_blend(head, fread(head, 1, sizeof head, file));
    fclose(file);
    cau_result result = blend ? read_blend(out, path, err) : host_read_file(&text, &size, path, err);
    if (!blend && result == CAU_OK) result = read_our_script(out, text, err);
    free(text);
    if (result != CAU_OK) error_prefix(err, "\"%s\": ", path);
    return result;
}
