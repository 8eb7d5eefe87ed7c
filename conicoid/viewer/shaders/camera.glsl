// A picture's point to a ray. origin = o₀ + u o₁ + v o₂, direction = d₀ + u d₁ + v d₂.

uniform vec3 u_lens[6];
uniform vec2 u_size;    // of the picture, in pixels

Ray camera_ray(vec2 pixel) {
    float u = (2.0 * pixel.x - u_size.x) / u_size.y, v = (2.0 * pixel.y - u_size.y) / u_size.y;
    vec3 o = u_lens[0] + u * u_lens[1] + v * u_lens[2];
    vec3 d = normalized(u_lens[3] + u * u_lens[4] + v * u_lens[5]);
    return Ray(o, d, 0.0, FAR, NO_SURFACE);
}
