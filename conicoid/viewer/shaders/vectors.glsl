// Vectors.

// v / |v|, scaled first so that no square overflows or underflows; zero stays zero
vec3 normalized(vec3 v) {
    float largest = max(max(abs(v.x), abs(v.y)), abs(v.z));
    if (largest == 0.0) return v;
    v /= largest;
    return v / length(v);
}
