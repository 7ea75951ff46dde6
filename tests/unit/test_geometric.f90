!> The geometric part: its matrices against an integration of the mode slopes written here, the assembled energy against the
!> direct sum over k_G elements and quadrature points, forces against differences of the energy.
program test_geometric
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_beam_element_matrices, only: bending_curvature, bending_slope
   use limber_beam_elastic_forces, only: elastic_energy, elastic_force, geometric_power
   use limber_beam_geometric_stiffness, only: element_ends, mean_slopes, mean_strains, pair_index
   use limber_beam_beam_mesh, only: beam_type, bending_modes, deflection_at, extension_at, displacement_field_type, mesh_beam, &
      & new_support, &
      & slope_at
   use limber_beam_reduced_body, only: reduced_type
   use limber_beam_beam_reduction, only: fidelity_kg, fidelity_linear, reduce_beam, reduction_type
   use scenes, only: derivative, gauss_point, gauss_weight, random
   use testing, only: check, check_close, check_no_error, finish
   implicit none
   !> Lengths and stiffnesses of the paper's rod, 24 elements unless a test says otherwise
   type(beam_type), parameter :: rod = beam_type(ea=5.65e6_wp, ei=12.7_wp, rho_a=0.2225_wp, length=0.3_wp, elements=24)

   call test_pairs()
   call test_interpolation()
   call test_mean_slopes(24, 6)
   call test_mean_slopes(7, 3)
   call test_mean_slopes(5, 8)
   call test_sum()
   call test_energy('PINNED-ROLLER', 4, 3, .false., 0.0_wp)
   call test_energy('PINNED-ROLLER', 3, 12, .false., 0.1_wp)
   call test_energy('CLAMPED-FREE', 3, 6, .false., 0.0_wp)
   call test_energy('FREE-FREE', 2, 4, .true., 0.15_wp)
   call test_energy('CLAMPED-ROLLER', 3, 7, .true., 0.0_wp)
   call test_energy('PINNED-PINNED', 1, 4, .false., 0.0_wp)
   call finish()

contains

   !> The order of the products: (1,1), (1,2), (2,2), (1,3), ...
   subroutine test_pairs()
      integer :: i, j, p
      p = 0
      do j = 1, 5
         do i = 1, j
            p = p + 1
            call check(pair_index(i, j) == p .and. pair_index(j, i) == p, 'places of the products')
         end do
      end do
   end subroutine test_pairs

   !> Deflection, slope and curvature of a field at x, by Hermite's cubic in its own words.
   pure subroutine shape_at(field, x, w, slope, curvature)
      type(displacement_field_type), intent(in) :: field
      real(wp), intent(in) :: x
      real(wp), intent(out) :: w(:), slope(:), curvature(:)
      real(wp) :: l, t, rise(size(w)), left(size(w)), right(size(w))
      integer :: e, n
      n = ubound(field%s, 1)
      e = min(n, max(1, 1 + int(x/field%s(n)*n)))
      l = field%s(e) - field%s(e - 1)
      t = (x - field%s(e - 1))/l
      ! Chord, and the rotations of both ends relative to it
      rise = (field%w(e, :) - field%w(e - 1, :))/l
      left = field%theta(e - 1, :) - rise
      right = field%theta(e, :) - rise
      w = field%w(e - 1, :) + rise*t*l + l*(left*t*(1 - t)**2 - right*t**2*(1 - t))
      slope = rise + left*(1 - t)*(1 - 3*t) + right*t*(3*t - 2)
      curvature = (left*(6*t - 4) + right*(6*t - 2))/l
   end subroutine shape_at

   !> Places along the beam against the formula above, the end included.
   subroutine test_interpolation()
      type(displacement_field_type) :: field
      type(error_type), allocatable :: error
      real(wp) :: x, w(4), slope(4), curvature(4)
      integer :: i
      field = mesh_beam(rod)
      call bending_modes(rod, new_support('CLAMPED-FREE'), 4, field, error)
      call check_no_error(error, 'modes')
      do i = 0, 50
         x = rod%length*i/50
         call shape_at(field, x, w, slope, curvature)
         call check(maxval(abs(deflection_at(field, x) - w)) <= 1.0e-13_wp*maxval(abs(field%w)), 'deflection at a place')
         call check(maxval(abs(slope_at(field, x, bending_slope) - slope)) <= 1.0e-12_wp*maxval(abs(field%theta)), &
            & 'slope at a place')
         call check(maxval(abs(slope_at(field, x, bending_curvature) - curvature)) <= 1.0e-10_wp*maxval(abs(field%theta)) &
            & /rod%length, 'curvature at a place')
      end do
   end subroutine test_interpolation

   !> Integral of a product of slopes (kind 1), or of slopes and curvatures of the deflection eta (kind 2), from a to b, in so
   !> many pieces that none crosses a node but by round-off.
   function slope_integral(field, a, b) result(matrix)
      type(displacement_field_type), intent(in) :: field
      real(wp), intent(in) :: a, b
      real(wp) :: matrix(size(field%w, 2), size(field%w, 2)), x, left, right
      real(wp), dimension(size(field%w, 2)) :: w, slope, curvature
      integer :: e, g, j
      matrix = 0.0_wp
      do e = 1, ubound(field%s, 1)
         left = min(max(field%s(e - 1), a), b)
         right = min(max(field%s(e), a), b)
         do g = 1, 5
            x = 0.5_wp*(left + right) + 0.5_wp*(right - left)*gauss_point(g)
            call shape_at(field, x, w, slope, curvature)
            do j = 1, size(slope)
               matrix(:, j) = matrix(:, j) + 0.5_wp*(right - left)*gauss_weight(g)*slope*slope(j)
            end do
         end do
      end do
   end function slope_integral

   !> B_g of both kinds; k_G elements that do not end at nodes too.
   subroutine test_mean_slopes(elements, parts)
      integer, intent(in) :: elements, parts
      integer, parameter :: number = 4
      type(beam_type) :: beam
      type(displacement_field_type) :: field
      type(error_type), allocatable :: error
      real(wp) :: x(0:parts), exact(number, number, parts), nodal(number, number, parts), own(number, number)
      real(wp), dimension(number) :: w(number, 2), theta(number, 2), curvature, slope
      real(wp) :: l, t
      integer :: g, k, j
      beam = rod
      beam%elements = elements
      field = mesh_beam(beam)
      call bending_modes(beam, new_support('PINNED-ROLLER'), number, field, error)
      call check_no_error(error, 'modes')
      x = element_ends(beam%length, parts)
      call check(abs(x(0)) <= 0.0_wp .and. abs(x(parts) - beam%length) <= 0.0_wp, 'the k_G elements cover the beam')
      exact = mean_slopes(field, x, .false.)
      nodal = mean_slopes(field, x, .true.)
      do g = 1, parts
         l = x(g) - x(g - 1)
         own = slope_integral(field, x(g - 1), x(g))/l
         call check(maxval(abs(exact(:, :, g) - own)) <= 1.0e-12_wp*maxval(abs(own)), 'the exact mean of w''^2')
         call check(maxval(abs(exact(:, :, g) - transpose(exact(:, :, g)))) <= 0.0_wp, 'it is symmetric')
         ! The cubic through w and theta at the two ends, slopes integrated over it
         call shape_at(field, x(g - 1), w(:, 1), theta(:, 1), curvature)
         call shape_at(field, x(g), w(:, 2), theta(:, 2), curvature)
         own = 0.0_wp
         do k = 1, 5
            t = 0.5_wp*(1 + gauss_point(k))
            slope = (w(:, 2) - w(:, 1))/l*6*t*(1 - t) + theta(:, 1)*(1 - t)*(1 - 3*t) + theta(:, 2)*t*(3*t - 2)
            do j = 1, number
               own(:, j) = own(:, j) + 0.5_wp*gauss_weight(k)*slope*slope(j)
            end do
         end do
         call check(maxval(abs(nodal(:, :, g) - own)) <= 1.0e-12_wp*maxval(abs(own)), 'the mean of w''^2 from the ends')
         call check(maxval(abs(nodal(:, :, g) - transpose(nodal(:, :, g)))) <= 0.0_wp, 'it is symmetric too')
      end do
      if (parts == elements) return
      call check(maxval(abs(exact - nodal)) > 1.0e-6_wp*maxval(abs(exact)) .or. parts > elements, &
         & 'the two kinds differ on coarse elements')
   end subroutine test_mean_slopes

   !> The sum of l_g B_g is the integral over the beam, whatever the division.
   subroutine test_sum()
      integer, parameter :: number = 5
      type(displacement_field_type) :: field
      type(error_type), allocatable :: error
      real(wp) :: whole(number, number, 1), total(number, number)
      real(wp), allocatable :: b(:, :, :), x(:)
      integer :: parts, g
      field = mesh_beam(rod)
      call bending_modes(rod, new_support('CLAMPED-FREE'), number, field, error)
      call check_no_error(error, 'modes')
      whole = mean_slopes(field, [0.0_wp, rod%length], .false.)
      do parts = 2, 30
         allocate (x(0:parts))
         x(:) = element_ends(rod%length, parts)
         b = mean_slopes(field, x, .false.)
         total = 0.0_wp
         do g = 1, parts
            total = total + b(:, :, g)*(x(g) - x(g - 1))/rod%length
         end do
         call check(maxval(abs(total - whole(:, :, 1))) <= 1.0e-13_wp*maxval(abs(whole)), 'the sum of all B_g')
         deallocate (x)
      end do
   end subroutine test_sum

   !> Energies and forces of both models at random coordinates.
   subroutine test_energy(support, bending, parts, nodal, origin)
      character(*), intent(in) :: support
      integer, intent(in) :: bending, parts
      logical, intent(in) :: nodal
      real(wp), intent(in) :: origin
      type(reduction_type) :: choice
      type(reduced_type) :: linear, kg
      type(displacement_field_type) :: field
      type(error_type), allocatable :: error
      integer :: trial
      choice = reduction_type(support=new_support(support), bending=bending, axial=3, geometric_elements=parts, &
         & nodal=nodal, origin=origin)
      choice%fidelity = fidelity_linear
      call reduce_beam(rod, choice, linear, field, error)
      call check_no_error(error, 'linear')
      choice%fidelity = fidelity_kg
      call reduce_beam(rod, choice, kg, field, error)
      call check_no_error(error, 'k_g')
      call check(kg%bending == bending .and. kg%n > bending, support//': bending and axial coordinates')
      do trial = 1, 3
         call compare(support, choice, field, linear, kg)
      end do
   end subroutine test_energy

   subroutine compare(support, choice, field, linear, kg)
      character(*), intent(in) :: support
      type(reduction_type), intent(in) :: choice
      type(displacement_field_type), intent(in) :: field
      type(reduced_type), intent(in) :: linear, kg
      real(wp), dimension(kg%n) :: eta, rate, step
      real(wp) :: scale, energy, power
      real(wp) :: s(size(kg%cubic, 1)), f(kg%n), expected(kg%n), x(0:choice%geometric_elements)
      real(wp) :: a(choice%geometric_elements, kg%n - kg%bending), u(2, kg%n - kg%bending)
      real(wp), allocatable :: b(:, :, :)
      integer :: g, i, nb
      nb = kg%bending
      ! Deflections of a tenth of the length; axial strains of a hundredth, so that all parts count
      eta(:nb) = [(0.1_wp*rod%length*random()/maxval(abs(field%w(:, i))), i=1, nb)]
      eta(nb + 1:) = [(0.01_wp*rod%length*random()/maxval(abs(field%u(:, i))), i=1, kg%n - nb)]
      rate = [(random(), i=1, kg%n)]
      x = element_ends(rod%length, choice%geometric_elements)
      b = mean_slopes(field, x, choice%nodal)
      do g = 1, choice%geometric_elements
         u(1, :) = extension_at(field, x(g - 1))
         u(2, :) = extension_at(field, x(g))
         a(g, :) = (u(2, :) - u(1, :))/(x(g) - x(g - 1))
      end do
      call check(maxval(abs(a - mean_strains(field, x))) <= 1.0e-14_wp*maxval(abs(a)), support//': mean strains')

      scale = 0.5_wp*sum([field%omega2_bending, field%omega2_axial]*eta**2)
      call elastic_energy(kg, eta, energy)
      call check_close(energy, scale, 1.0e-14_wp*scale, support//': energy of k_g is that of K_E')
      call elastic_energy(linear, eta, energy)
      call check_close(energy, scale, 1.0e-14_wp*scale, support//': energy of the linear model')

      ! The energy is a square, for which the stencil is exact; steps as large as the coordinates
      step = 0.5_wp*abs(eta) + 1.0e-3_wp*maxval(abs(eta))
      f = 0.0_wp
      call elastic_force(linear, eta, f, s)
      do i = 1, kg%n
         expected(i) = energy_slope(linear, eta, i, step(i))
      end do
      call check(all(abs(f - expected) <= 1.0e-11_wp*(maxval(abs(f)) + scale/step)), support//': force of the linear model')
      call check(maxval(abs(f - linear%omega2*eta)) <= 1.0e-15_wp*maxval(abs(f)), support//': it is K_E eta')

      expected = kg%omega2*eta
      do g = 1, choice%geometric_elements
         expected(:nb) = expected(:nb) + (x(g) - x(g - 1))*rod%ea*dot_product(a(g, :), eta(nb + 1:))*matmul(b(:, :, g), eta(:nb))
      end do
      f = 0.0_wp
      call elastic_force(kg, eta, f, s)
      call check(maxval(abs(f - expected)) <= 1.0e-12_wp*maxval(abs(expected)), support//': force of the model k_g')
      call check(maxval(abs(f - kg%omega2*eta)) > 1.0e-3_wp*maxval(abs(f(:nb))), support//': the tension counts')
      call geometric_power(kg, eta, rate, s, power)
      call check_close(power, dot_product(f - kg%omega2*eta, rate), 1.0e-12_wp*sum(abs(f*rate)), support//': power of k_g')
      call geometric_power(linear, eta, rate, s, power)
      call check_close(power, 0.0_wp, 0.0_wp, support//': the linear model takes no power')
   end subroutine compare

   !> Derivative of the elastic energy with respect to one coordinate.
   real(wp) function energy_slope(body, eta, i, h) result(slope)
      type(reduced_type), intent(in) :: body
      real(wp), intent(in) :: eta(:), h
      integer, intent(in) :: i
      real(wp) :: value(-2:2), moved(size(eta))
      integer :: k
      do k = -2, 2
         moved = eta
         moved(i) = eta(i) + k*h
         call elastic_energy(body, moved, value(k))
      end do
      slope = derivative(value(-2), value(-1), value(1), value(2), h)
   end function energy_slope

end program test_geometric
