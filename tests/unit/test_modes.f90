!> Vibration modes against closed forms of the lumped chain, against a dense solution with the massless rotations condensed
!> by hand, and against each other (ARPACK and LAPACK).
program test_modes
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_lapack, only: dgetrf, dgetrs, dsyev
   use limber_beam_beam_mesh, only: axial_modes, beam_type, bending_modes, count_axial_modes, count_bending_modes, &
      & displacement_field_type, &
      & mesh_beam, new_support, nodal_masses, support_type
   use limber_beam_modal_reduction, only: count_modes
   use testing, only: check, check_close, check_no_error, check_text, finish
   implicit none
   real(wp), parameter :: pi = acos(-1.0_wp)
   real(wp), parameter :: length = 0.7_wp, ea = 3.0e5_wp, ei = 11.0_wp, rho_a = 0.4_wp
   character(15), parameter :: names(7) = [character(15) :: 'PINNED-ROLLER', 'PINNED-PINNED', 'CLAMPED-FREE', &
      & 'CLAMPED-ROLLER', 'CLAMPED-PINNED', 'CLAMPED-CLAMPED', 'FREE-FREE']
   integer :: i

   call test_names()
   call test_simply_supported()
   call test_axial()
   call test_cantilever()
   call test_count()
   do i = 1, size(names)
      call test_against_dense(trim(names(i)))
      call test_orthogonality(trim(names(i)))
      call test_paths(trim(names(i)))
      call test_repeatable(trim(names(i)))
   end do
   call test_limits()
   call test_free_free()
   call finish()

contains

   pure type(beam_type) function beam_of(elements) result(beam)
      integer, intent(in) :: elements
      beam = beam_type(ea=ea, ei=ei, rho_a=rho_a, length=length, elements=elements)
   end function beam_of

   !> What each name holds: u, w, theta at the start, u, w, theta at the end.
   subroutine test_names()
      character(6), parameter :: held(7) = ['110010', '110110', '111000', '111010', '111110', '111111', '000000']
      type(support_type) :: s
      character(6) :: found
      integer :: i
      do i = 1, size(names)
         s = new_support(trim(names(i)))
         write (found, '(6i1)') merge(1, 0, [s%u_start, s%w_start, s%theta_start, s%u_end, s%w_end, s%theta_end])
         call check_text(found, held(i), trim(names(i)))
      end do
   end subroutine test_names

   !> Every mode of every division, w_k = (n/L)^2 sqrt(EI/m) (1 - cos b) sqrt(12/(2 + cos b)), b = k pi/n: the finite
   !> difference equation of the chain with its rotations condensed. Its shape is a sine at the nodes.
   subroutine test_simply_supported()
      type(beam_type) :: beam
      type(displacement_field_type) :: field
      type(error_type), allocatable :: error
      real(wp) :: b, exact, worst, worst_shape
      integer :: n, k, i
      worst = 0.0_wp
      worst_shape = 0.0_wp
      do n = 2, 24
         beam = beam_of(n)
         field = mesh_beam(beam)
         call bending_modes(beam, new_support('PINNED-ROLLER'), n - 1, field, error)
         call check_no_error(error, 'simply supported')
         do k = 1, n - 1
            b = k*pi/n
            exact = (n/length)**2*sqrt(ei/rho_a)*(1 - cos(b))*sqrt(12/(2 + cos(b)))
            worst = max(worst, abs(sqrt(field%omega2_bending(k))/exact - 1))
            worst_shape = max(worst_shape, maxval(abs(field%w(:, k) - sqrt(2/(rho_a*length))*sin([(b*i, i=0, n)]))))
         end do
      end do
      call check_close(worst, 0.0_wp, 1.0e-10_wp, 'frequencies of the simply supported chain')
      call check_close(worst_shape, 0.0_wp, 1.0e-9_wp, 'its shapes are sines, positive at the start')
   end subroutine test_simply_supported

   !> Axial chain of n springs n EA/L and masses m L/n, half a mass at either end. u_j = sin(j b) solves the inner equations
   !> with w = 2 (n/L) sqrt(EA/m) sin(b/2); the half mass at a free end asks for cos(n b) = 0, a held one for sin(n b) = 0;
   !> free at both ends u_j = cos(j b), sin(n b) = 0.
   subroutine test_axial()
      integer :: n, k
      real(wp) :: worst(3)
      type(beam_type) :: beam
      type(displacement_field_type) :: field
      type(error_type), allocatable :: error
      worst = 0.0_wp
      do n = 2, 20
         beam = beam_of(n)
         field = mesh_beam(beam)
         call axial_modes(beam, new_support('PINNED-ROLLER'), n, field, error)
         call check_no_error(error, 'axial, free at the end')
         worst(1) = max(worst(1), maxval(abs(sqrt(field%omega2_axial)/frequency(n, [((2*k - 1)*pi/(2*n), k=1, n)]) - 1)))
         field = mesh_beam(beam)
         call axial_modes(beam, new_support('PINNED-PINNED'), n - 1, field, error)
         call check_no_error(error, 'axial, held at both ends')
         worst(2) = max(worst(2), maxval(abs(sqrt(field%omega2_axial)/frequency(n, [(k*pi/n, k=1, n - 1)]) - 1)))
         field = mesh_beam(beam)
         call axial_modes(beam, new_support('FREE-FREE'), n, field, error)
         call check_no_error(error, 'axial, free at both ends')
         worst(3) = max(worst(3), maxval(abs(sqrt(field%omega2_axial)/frequency(n, [(k*pi/n, k=1, n)]) - 1)))
      end do
      call check_close(worst(1), 0.0_wp, 1.0e-11_wp, 'axial frequencies, free at the end')
      call check_close(worst(2), 0.0_wp, 1.0e-11_wp, 'axial frequencies, held at both ends')
      call check_close(worst(3), 0.0_wp, 1.0e-11_wp, 'axial frequencies, free at both ends')
   end subroutine test_axial

   pure elemental real(wp) function frequency(n, b)
      integer, intent(in) :: n
      real(wp), intent(in) :: b
      frequency = 2*(n/length)*sqrt(ea/rho_a)*sin(b/2)
   end function frequency

   !> First frequency of the lumped cantilever in units of sqrt(EI/m)/L^2, computed elsewhere to eight figures.
   subroutine test_cantilever()
      integer, parameter :: n(6) = [1, 2, 4, 8, 16, 32]
      real(wp), parameter :: exact(6) = [2.4494897_wp, 3.1562325_wp, 3.4180394_wp, 3.4909879_wp, 3.5097247_wp, 3.5144405_wp]
      real(wp) :: value
      integer :: i
      do i = 1, size(n)
         value = first_frequency('CLAMPED-FREE', n(i))
         call check_close(value, exact(i), 5.1e-8_wp, 'cantilever')
      end do
   end subroutine test_cantilever

   !> First bending frequency in units of sqrt(EI/m)/L^2.
   real(wp) function first_frequency(name, elements) result(value)
      character(*), intent(in) :: name
      integer, intent(in) :: elements
      type(beam_type) :: beam
      type(displacement_field_type) :: field
      type(error_type), allocatable :: error
      beam = beam_of(elements)
      field = mesh_beam(beam)
      call bending_modes(beam, new_support(name), 1, field, error)
      call check_no_error(error, name)
      value = sqrt(field%omega2_bending(1))*length**2*sqrt(rho_a/ei)
   end function first_frequency

   !> As many modes as free coordinates with mass, less the rigid-body motions; one more is an error.
   subroutine test_count()
      integer, parameter :: bending(7) = [3, 3, 4, 3, 3, 3, 3], axial(7) = [4, 3, 4, 4, 3, 3, 4]
      type(beam_type) :: beam
      type(displacement_field_type) :: field
      type(error_type), allocatable :: error
      integer :: i
      call check(count_bending_modes(beam_of(2), new_support('PINNED-ROLLER')) == 1, 'two elements: one bending mode')
      call check(count_axial_modes(beam_of(2), new_support('PINNED-ROLLER')) == 2, 'two elements: two axial modes')
      call check(count_modes([1.0_wp, 0.0_wp, 2.0_wp], 3) == 0, 'never less than no mode')
      beam = beam_of(4)
      do i = 1, size(names)
         call check(count_bending_modes(beam, new_support(trim(names(i)))) == bending(i), 'bending modes, '//names(i))
         call check(count_axial_modes(beam, new_support(trim(names(i)))) == axial(i), 'axial modes, '//names(i))
         field = mesh_beam(beam)
         call bending_modes(beam, new_support(trim(names(i))), bending(i) + 1, field, error)
         call check(allocated(error), 'one bending mode too many, '//names(i))
         if (allocated(error)) call check(index(error%message, 'modes') > 0 .and. index(error%message, 'asked for') > 0, &
            & 'the error tells how many modes there are')
         call axial_modes(beam, new_support(trim(names(i))), axial(i) + 1, field, error)
         call check(allocated(error), 'one axial mode too many, '//names(i))
      end do
   end subroutine test_count

   !> Stiffness of a whole beam on (w, theta) of all nodes, written anew.
   pure function whole_stiffness(n) result(k)
      integer, intent(in) :: n
      real(wp) :: k(2*n + 2, 2*n + 2), l, turns(2, 4), bend(2, 2)
      integer :: e
      l = length/n
      ! The energy is 2 EI/l (a^2 + a b + b^2), a and b the rotations of the ends relative to the chord
      turns(1, :) = [1/l, 1.0_wp, -1/l, 0.0_wp]
      turns(2, :) = [1/l, 0.0_wp, -1/l, 1.0_wp]
      bend = reshape([4.0_wp, 2.0_wp, 2.0_wp, 4.0_wp], [2, 2])*(ei/l)
      k = 0.0_wp
      do e = 1, n
         associate (part => k(2*e - 1:2*e + 2, 2*e - 1:2*e + 2))
            part = part + matmul(transpose(turns), matmul(bend, turns))
         end associate
      end do
   end function whole_stiffness

   !> Squared frequencies by condensing the rotations and a dense solution of M^(-1/2) K M^(-1/2), ascending, rigid ones too.
   function dense_frequencies(n, support) result(omega2)
      integer, intent(in) :: n
      type(support_type), intent(in) :: support
      real(wp), allocatable :: omega2(:), k(:, :), ktt(:, :), ktw(:, :), kww(:, :), work(:), mass(:)
      logical :: free_w(0:n), free_t(0:n)
      integer, allocatable :: iw(:), it(:), pivots(:)
      integer :: i, info
      k = whole_stiffness(n)
      free_w = .true.
      free_t = .true.
      free_w(0) = .not. support%w_start
      free_w(n) = .not. support%w_end
      free_t(0) = .not. support%theta_start
      free_t(n) = .not. support%theta_end
      iw = 2*pack([(i, i=0, n)], free_w) + 1
      it = 2*pack([(i, i=0, n)], free_t) + 2
      kww = k(iw, iw)
      if (size(it) > 0) then
         ktt = k(it, it)
         ktw = k(it, iw)
         allocate (pivots(size(it)))
         call dgetrf(size(it), size(it), ktt, size(it), pivots, info)
         call dgetrs('N', size(it), size(iw), ktt, size(it), pivots, ktw, size(it), info)
         kww = kww - matmul(k(iw, it), ktw)
      end if
      mass = rho_a*length/n*merge(0.5_wp, 1.0_wp, [(i == 0 .or. i == n, i=0, n)])
      mass = pack(mass, free_w)
      do i = 1, size(iw)
         kww(:, i) = kww(:, i)/sqrt(mass*mass(i))
      end do
      allocate (omega2(size(iw)), work(10*size(iw) + 10))
      call dsyev('N', 'L', size(iw), kww, size(iw), omega2, work, size(work), info)
      call check(info == 0, 'the dense solution')
   end function dense_frequencies

   !> All modes of small divisions.
   subroutine test_against_dense(name)
      character(*), intent(in) :: name
      type(beam_type) :: beam
      type(displacement_field_type) :: field
      type(support_type) :: support
      type(error_type), allocatable :: error
      real(wp), allocatable :: exact(:)
      integer :: n, number, rigid
      support = new_support(name)
      do n = 2, 12
         beam = beam_of(n)
         number = count_bending_modes(beam, support)
         field = mesh_beam(beam)
         call bending_modes(beam, support, number, field, error)
         call check_no_error(error, name)
         exact = dense_frequencies(n, support)
         rigid = size(exact) - number
         call check(rigid == merge(2, 0, name == 'FREE-FREE'), name//': rigid motions')
         ! The condensed matrix itself carries errors of 1e-16 of its largest eigenvalue
         call check(all(abs(field%omega2_bending - exact(rigid + 1:)) <= 2.0e-12_wp*exact(size(exact)) &
            & + 1.0e-12_wp*exact(rigid + 1:)), name//': bending modes against the dense solution')
      end do
   end subroutine test_against_dense

   !> Phi^T M Phi = I and Phi^T K Phi = diag(w^2) on all coordinates, rotations included; what is held stays.
   subroutine test_orthogonality(name)
      character(*), intent(in) :: name
      integer, parameter :: n = 14, number = 6
      type(beam_type) :: beam
      type(displacement_field_type) :: field
      type(support_type) :: support
      type(error_type), allocatable :: error
      real(wp) :: mass(0:n), gram(number, number), stiff(number, number), phi(2*n + 2, number), product
      integer :: i, j
      beam = beam_of(n)
      support = new_support(name)
      field = mesh_beam(beam)
      call bending_modes(beam, support, number, field, error)
      call check_no_error(error, name)
      call axial_modes(beam, support, number, field, error)
      call check_no_error(error, name)
      call check(size(field%w, 2) == number .and. lbound(field%w, 1) == 0 .and. ubound(field%w, 1) == n, &
         & name//': nodes from 0 to n')
      mass = nodal_masses(beam)
      call check_close(sum(mass), rho_a*length, 1.0e-15_wp, name//': the whole mass')
      phi(1::2, :) = field%w
      phi(2::2, :) = field%theta
      do j = 1, number
         do i = 1, number
            gram(i, j) = sum(mass*field%w(:, i)*field%w(:, j))
         end do
      end do
      stiff = matmul(transpose(phi), matmul(whole_stiffness(n), phi))
      call check_identity(gram, 1.0e-11_wp, name//': bending modes orthonormal in the mass')
      do j = 1, number
         stiff(:, j) = stiff(:, j)/sqrt(field%omega2_bending*field%omega2_bending(j))
      end do
      ! Entries of K Phi cancel by h^4, a factor of 1e4
      call check_identity(stiff, 2.0e-10_wp, name//': bending modes orthogonal in the stiffness')
      do j = 1, number
         do i = 1, number
            gram(i, j) = sum(mass*field%u(:, i)*field%u(:, j))
            product = sum((field%u(1:, i) - field%u(:n - 1, i))*(field%u(1:, j) - field%u(:n - 1, j)))*ea*n/length
            stiff(i, j) = product/sqrt(field%omega2_axial(i)*field%omega2_axial(j))
         end do
      end do
      call check_identity(gram, 1.0e-12_wp, name//': axial modes orthonormal in the mass')
      call check_identity(stiff, 1.0e-12_wp, name//': axial modes orthogonal in the stiffness')
      call check(.not. support%w_start .or. maxval(abs(field%w(0, :))) <= 0.0_wp, name//': w held at the start')
      call check(.not. support%theta_start .or. maxval(abs(field%theta(0, :))) <= 0.0_wp, name//': theta held at the start')
      call check(.not. support%u_start .or. maxval(abs(field%u(0, :))) <= 0.0_wp, name//': u held at the start')
      call check(.not. support%w_end .or. maxval(abs(field%w(n, :))) <= 0.0_wp, name//': w held at the end')
      call check(.not. support%theta_end .or. maxval(abs(field%theta(n, :))) <= 0.0_wp, name//': theta held at the end')
      call check(.not. support%u_end .or. maxval(abs(field%u(n, :))) <= 0.0_wp, name//': u held at the end')
      call check(support%w_start .or. minval(abs(field%w(0, :))) > 0.1_wp, name//': w free at the start')
      call check(support%w_end .or. minval(abs(field%w(n, :))) > 0.1_wp, name//': w free at the end')
      call check(support%u_end .or. minval(abs(field%u(n, :))) > 0.1_wp, name//': u free at the end')
   end subroutine test_orthogonality

   subroutine check_identity(matrix, tolerance, name)
      real(wp), intent(in) :: matrix(:, :), tolerance
      character(*), intent(in) :: name
      real(wp) :: worst
      integer :: i, j
      worst = 0.0_wp
      do j = 1, size(matrix, 2)
         do i = 1, size(matrix, 1)
            worst = max(worst, abs(matrix(i, j) - merge(1.0_wp, 0.0_wp, i == j)))
         end do
      end do
      call check_close(worst, 0.0_wp, tolerance, name)
   end subroutine check_identity

   !> ARPACK gives what LAPACK gives when all modes are asked for.
   subroutine test_paths(name)
      character(*), intent(in) :: name
      integer, parameter :: n = 13
      type(beam_type) :: beam
      type(displacement_field_type) :: whole, part
      type(support_type) :: support
      type(error_type), allocatable :: error
      integer :: number, j
      beam = beam_of(n)
      support = new_support(name)
      whole = mesh_beam(beam)
      number = count_bending_modes(beam, support)
      call bending_modes(beam, support, number, whole, error)
      call check_no_error(error, name)
      do j = 1, number - 1
         part = mesh_beam(beam)
         call bending_modes(beam, support, j, part, error)
         call check_no_error(error, name)
         if (allocated(error)) exit
         call check(maxval(abs(part%omega2_bending/whole%omega2_bending(:j) - 1)) <= 1.0e-10_wp, &
            & name//': bending frequencies by ARPACK and LAPACK')
         call check(maxval(abs(part%w - whole%w(:, :j))) <= 1.0e-8_wp*maxval(abs(whole%w)), name//': bending shapes by both')
         call check(maxval(abs(part%theta - whole%theta(:, :j))) <= 1.0e-8_wp*maxval(abs(whole%theta)), name//': slopes by both')
      end do
      number = count_axial_modes(beam, support)
      call axial_modes(beam, support, number, whole, error)
      call check_no_error(error, name)
      do j = 1, number - 1
         call axial_modes(beam, support, j, part, error)
         call check_no_error(error, name)
         if (allocated(error)) exit
         call check(maxval(abs(part%omega2_axial/whole%omega2_axial(:j) - 1)) <= 1.0e-11_wp, &
            & name//': axial frequencies by ARPACK and LAPACK')
         call check(maxval(abs(part%u - whole%u(:, :j))) <= 1.0e-8_wp*maxval(abs(whole%u)), name//': axial shapes by both')
      end do
   end subroutine test_paths

   !> The same to the last bit, also after something else was computed.
   subroutine test_repeatable(name)
      character(*), intent(in) :: name
      type(displacement_field_type) :: first, between, second
      type(error_type), allocatable :: error
      integer :: round
      do round = 1, 2
         first = mesh_beam(beam_of(30))
         call bending_modes(beam_of(30), new_support(name), 5, first, error)
         call check_no_error(error, name)
         call axial_modes(beam_of(30), new_support(name), 4, first, error)
         call check_no_error(error, name)
         if (round == 1) second = first
         between = mesh_beam(beam_of(17))
         call bending_modes(beam_of(17), new_support('CLAMPED-FREE'), 3, between, error)
      end do
      call check(maxval(abs(first%omega2_bending - second%omega2_bending)) <= 0.0_wp .and. &
         & maxval(abs(first%omega2_axial - second%omega2_axial)) <= 0.0_wp, name//': frequencies repeat to the bit')
      call check(maxval(abs(first%w - second%w)) <= 0.0_wp .and. maxval(abs(first%theta - second%theta)) <= 0.0_wp .and. &
         & maxval(abs(first%u - second%u)) <= 0.0_wp, name//': shapes repeat to the bit')
   end subroutine test_repeatable

   !> The continuous beam's first frequency in the limit; the lumped error falls with n^-2 (free ends) or faster.
   subroutine test_limits()
      real(wp), parameter :: exact(7) = [pi**2, pi**2, 3.51601527_wp, 15.41820572_wp, 15.41820572_wp, 22.37328545_wp, &
         & 22.37328545_wp]
      integer :: i
      do i = 1, size(names)
         call check_close(first_frequency(trim(names(i)), 48)/exact(i), 1.0_wp, 2.0e-3_wp, names(i))
      end do
   end subroutine test_limits

   !> No rigid motion in the modes of a free beam; second order towards 22.3733.
   subroutine test_free_free()
      integer, parameter :: number = 5
      type(beam_type) :: beam
      type(displacement_field_type) :: field
      type(error_type), allocatable :: error
      real(wp), parameter :: exact = 22.373285448_wp
      real(wp), allocatable :: mass(:)
      real(wp) :: value(4)
      integer :: i, j
      do i = 1, 4
         beam = beam_of(8*2**(i - 1))
         field = mesh_beam(beam)
         call bending_modes(beam, new_support('FREE-FREE'), number, field, error)
         call check_no_error(error, 'free-free')
         call axial_modes(beam, new_support('FREE-FREE'), number, field, error)
         call check_no_error(error, 'free-free, axial')
         mass = nodal_masses(beam)
         do j = 1, number
            call check(abs(sum(mass*field%w(:, j))) <= 1.0e-11_wp*sqrt(rho_a*length), 'no translation in a free mode')
            call check(abs(sum(mass*field%s*field%w(:, j))) <= 1.0e-11_wp*length*sqrt(rho_a*length), 'no rotation in a free mode')
            call check(abs(sum(mass*field%u(:, j))) <= 1.0e-12_wp*sqrt(rho_a*length), 'no translation in a free axial mode')
         end do
         value(i) = sqrt(field%omega2_bending(1))*length**2*sqrt(rho_a/ei)
      end do
      call check_close((exact - value(3))/(exact - value(4)), 4.0_wp, 0.1_wp, 'free-free: second order')
      call check_close((4*value(4) - value(3))/3, exact, 2.0e-4_wp*exact, 'free-free: the limit')
   end subroutine test_free_free

end program test_modes
