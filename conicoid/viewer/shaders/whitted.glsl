// Whitted's ray tracing. What functions of the engine do by calling each other is done here step by step, each step
// one walk through the scene.

const float FAINT = 2.44140625e-4;   // a ray that adds less than this share is not followed

struct Pending {
    vec3 o, d, weight;
    int start, turns, medium;
};

Pending rays[RAYS];
int ray_count;

void push(Pending ray) {
    if (max(ray.weight.r, max(ray.weight.g, ray.weight.b)) < FAINT || ray_count >= RAYS) return;
    rays[ray_count++] = ray;
}

// tasks, one walk each
const int CAMERA_MEDIUM = 0, TAKE = 1, VISIBLE = 2, WALL = 3, SHADOW = 4, SHADOW_WALL = 5, SHADOW_MEDIA = 6;

uniform int u_depth;

// (linear rgb, 1 where the first ray meets a surface); `first` is what it meets
vec4 whitted_radiance(vec3 o, vec3 d) {
    vec3 sum = vec3(0.0);
    float covered = 0.0;
    ray_count = 0;
    int task = ANY_TRANSPARENT == 1 ? CAMERA_MEDIUM : TAKE;
    Pending now = Pending(o, d, vec3(1.0), NO_SURFACE, 0, OUTSIDE);
    if (task == TAKE) push(now);
    Ray ray;
    Hit hit, wall;
    Material m;
    int before = OUTSIDE, after = OUTSIDE, light_number = 0, mode = NOTICED;
    float t_min = 0.0;
    vec3 x, n, color, reflectance, transmitted, diffuse, shine, through;
    Arrival arrival;
    bool refracts = false, from_inside = false, lit = false;
    float light_done = 0.0;
    int shadow_medium = OUTSIDE;
    for (int step = 0; step < STEPS; step++) {
        if (task == TAKE) {
            if (ray_count == 0) break;
            now = rays[--ray_count];
            t_min = 0.0;
            task = VISIBLE;
        }
        // One walk through the scene
        if (task == CAMERA_MEDIUM) { ray = Ray(o, vec3(0.0, 0.0, 1.0), 0.0, FAR, NO_SURFACE); mode = MEDIA_AT; }
        else if (task == VISIBLE) { ray = Ray(now.o, now.d, t_min, FAR, now.start); mode = NOTICED; }
        else if (task == WALL) { ray = Ray(now.o, now.d, hit.t, FAR, now.start); mode = MEDIA_AT; }
        else if (task == SHADOW) mode = BLOCKED;
        else if (task == SHADOW_WALL) mode = NEAREST;
        else { ray.t_min = wall.t; mode = MEDIA_AT; }
        Hit found = traverse(ray, mode, 0x7fffffff);
        bool shade = false, shadow_done = false;

        if (task == CAMERA_MEDIUM) {
            now.medium = medium_of(found.media.y);
            push(now);
            task = TAKE;
            continue;
        } else if (task == VISIBLE) {
            hit = found;
            if (hit.body < 0) {
                sum += absorbed(now.medium, FAR, now.weight) * background_color(now.d.z);
                task = TAKE;
                continue;
            }
            if (now.turns == 0) covered = 1.0;
            if (hit.surface == CUT) {
                // The cut of the section plane shows the body's own colour, flat
                m = load_material(material_row(hit.body, -1));
                vec3 flat_color = max(max(m.color.r, m.color.g), m.color.b) * m.diffuse > 0.02 ? m.color : vec3(0.35, 0.55, 0.75);
                if ((flags_of(hit.body) & TINTED) != 0)
                    flat_color = surface_color(m, hit.body, -1, CUT, now.o + hit.t * now.d, u_section.xyz);
                sum += now.weight * flat_color * 0.9;
                task = TAKE;
                continue;
            }
            before = after = OUTSIDE;
#if ANY_TRANSPARENT
            task = WALL;
            continue;
#else
            shade = true;
#endif
        } else if (task == WALL) {
            before = medium_of(found.media.x);
            after = medium_of(found.media.y);
            shade = (flags_of(hit.body) & MEDIUM) == 0 || !unseen(hit.body, before, after);
            if (!shade) {
                t_min = hit.t;
                task = VISIBLE;
                continue;
            }
        } else if (task == SHADOW) {
            through = vec3(found.body >= 0 ? 0.0 : 1.0);
            shadow_done = found.body >= 0 || ANY_TRANSPARENT == 0;
            light_done = 0.0;
            shadow_medium = before;
            if (!shadow_done) { task = SHADOW_WALL; continue; }
        } else if (task == SHADOW_WALL) {
            wall = found;
            if (wall.body >= 0) { task = SHADOW_MEDIA; continue; }
            through = absorbed(shadow_medium, (ray.t_max - light_done) * length(arrival.l), through);
            shadow_done = true;
        } else {
            int inside = medium_of(found.media.x), beyond = medium_of(found.media.y);
            if ((flags_of(wall.body) & MEDIUM) == 0 || inside != beyond) {
                float size = length(arrival.l);
                through = absorbed(inside, (wall.t - light_done) * size, through);
                vec3 normal = normal_at(wall.surface, wall.side, x + wall.t * arrival.l);
                float cosine = abs(dot(arrival.l, normal)) / size;
                float kept = 1.0 - wall_reflectance(cosine, index_of(inside), index_of(beyond));
                through *= kept * load_material(medium_of(wall.body)).transparency;
                light_done = wall.t;
            }
            shadow_medium = beyond;
            task = SHADOW_WALL;
            continue;
        }

        if (shade) {
            // The surface there, its normal turned to the eye
            now.weight = absorbed(before, hit.t, now.weight);
            m = load_material(material_row(hit.body, hit.face));
            x = on_surface(hit.surface, now.o + hit.t * now.d);
            n = normal_at(hit.surface, hit.side, x);
            color = surface_color(m, hit.body, hit.face, hit.surface, x, n);
            float cosine = -dot(n, now.d);
            from_inside = cosine < 0.0;
            if (from_inside) { n = -n; cosine = -cosine; }
            // How light parts there
            refracts = (flags_of(hit.body) & MEDIUM) != 0;
            reflectance = opaque_reflectance(m, cosine);
            transmitted = now.d;
            if (refracts) {
                float eta = index_of(before) / index_of(after);
                vec4 bent = refracted(now.d, n, eta);
                transmitted = bent.xyz;
                reflectance = vec3(dielectric(cosine, bent.w, eta));
            }
            lit = !(refracts && from_inside);
            diffuse = shine = vec3(0.0);
            light_number = lit ? 0 : u_light_count;
        }
        if (shadow_done) {
            vec3 arrived = through * arrival.share * load_light(light_number).intensity;
            diffuse += arrived * arrival.cosine;
            shine += arrived * arrival.shine;
            light_number++;
        }
        // The next light that could add something
        bool waiting = false;
        for (; light_number < u_light_count; light_number++) {
            arrival = light_at(load_light(light_number), m, x, n, -now.d);
            if (arrival.share == 0.0) continue;
            ray = Ray(x, arrival.l, 0.0, arrival.end, hit.surface);
            waiting = true;
            break;
        }
        if (waiting) { task = SHADOW; continue; }
        // Its own light
        if (lit) sum += now.weight * (color * (m.ambient * u_ambient + m.diffuse * diffuse)
                                      * (1.0 - reflectance) * (1.0 - m.transparency) + m.specular * shine);
        // On along the refracted and the mirrored ray
        task = TAKE;
        if (now.turns == u_depth) continue;
        push(Pending(x, transmitted, now.weight * (1.0 - reflectance) * m.transparency, hit.surface, now.turns + 1,
                     refracts ? after : before));
        push(Pending(x, reflect(now.d, n), now.weight * reflectance, hit.surface, now.turns + 1, before));
    }
    return vec4(sum, covered);
}
