#include "cli/render/task.h"

#include "base/clock.h"

static fathom_status run(int argc, char **argv) {
    task s = {.start = clock_seconds(), .framing = {.size = sizeof s.framing}};
    fathom_settings settings;
    fathom_status status;
    args_problem problem;
    fathom_settings_default(&settings);
    render_options_default(&s.options);
    if (!command_parse(&command_render, argc, argv, &s.options, &status)) return status;
    if (frames_asked(&s.options.frames)) return sequence_run(&s);
    if (!render_options_finish(&s.options, &settings, &problem))
        return say_usage(&command_render, problem.text);
    return task_run(&s);
}

const command command_render = {
    .name = "render",
    .usage = "SCENE -o IMAGE [-o IMAGE2 ...] [options]",
    .summary = "Render a scene to an image.",
    .text = "SCENE is scene JSON (.json) or a model: .glb, .gltf, .obj, .ply. A model without\n"
            "camera or lights gets a camera that frames it, and lights.\n"
            "Without --spp, path tracing samples each tile until its estimated error is\n"
            "0.02, with at most 1024 samples per pixel; with --target-error or --max-time,\n"
            "65536.\n"
            "Ctrl-C stops the render and writes the unfinished image to NAME.partial.EXT. It\n"
            "keeps an existing NAME.EXT; the exit code is 5. SIGTERM, SIGHUP (a closed\n"
            "terminal) and SIGXCPU (ulimit -t) do the same.\n"
            "If an image cannot be written, its pixels go to NAME.rescue.exr next to it, or\n"
            "to the working folder, $TMPDIR or /tmp, and a message says where. The same\n"
            "happens if the scene's files change during the render: exit code 3.\n"
            "With --checkpoint FILE, a stopped or killed render can be continued: --resume.\n"
            "When the render is complete, NAME.partial.EXT and FILE are removed.\n"
            "-o FILE.part renders a part of the image, on one of many machines. fathom merge\n"
            "joins the parts to an image with the same bits as a render on one machine.\n",
    .examples = "  fathom render bunny.obj -o bunny.png\n"
                "  fathom render scan.ply -o scan.png --up z --size 1080x1920\n"
                "  fathom render scene.json -o out.exr -o out.png --size 1920x1080 --spp 16\n"
                "  fathom render scene.json -o out.exr --aov Z,N,id --stats out.json\n"
                "  fathom render scene.json -o out.png --target-error 0.01\n"
                "  fathom render scene.json -o out.png --max-time 60\n"
                "  fathom render scene.json -o out.exr --checkpoint out.save --resume\n"
                "  fathom render walk.glb -o walk.####.exr --frames 1-48 --fps 24\n"
                "  fathom render scene.json -o p3.part --part 3/16\n"
                "  mpirun -n 8 fathom render scene.json -o out.exr --mpi\n",
    .args = {NULL, {{"SCENE", offsetof(render_options, scene)}}, 0, render_option_table},
    .run = run,
};
